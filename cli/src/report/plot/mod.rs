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

use super::markup::{Markup, Px};

/// Draws a picture of `width` by `height` pixels into a page: `content`, described for who cannot see it.
fn draw_picture(
    markup: &mut Markup,
    [width, height]: [f64; 2],
    description: &str,
    content: impl FnOnce(&mut Markup),
) {
    let size = format!("0 0 {} {}", Px(width), Px(height));
    markup.element(
        "svg",
        &[
            ("viewBox", &size),
            ("role", &"img"),
            ("aria-label", &description),
        ],
        content,
    );
    markup.end_line();
}
