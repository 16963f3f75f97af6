//! Plots as SVG, drawn here: axes, lines, scattered marks, bars and the places of their names.
//!
//! Every plot can be part of a page, whose style sheet then says what its classes look like in light and dark; a
//! [`LinePlot`](lines::LinePlot) can be a document of its own as well.

pub mod bars;
pub mod frame;
pub mod labels;
pub mod lines;
pub mod marks;
pub mod scale;
pub mod scatter;
