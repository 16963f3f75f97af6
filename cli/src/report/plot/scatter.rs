//! Plots of marks on two logarithmic axes, with their Pareto front and the names of those on it.

use super::super::markup::{Markup, Px};
use super::super::panel::shown;
use super::super::pareto;
use super::draw_picture;
use super::frame::{Axis, Frame};
use super::labels::{self, Rectangle};
use super::marks::Look;

/// A mark.
#[derive(Clone, Debug)]
pub struct Mark {
    /// Name, written beside it if it is on the front.
    pub name: String,
    /// How it looks.
    pub look: Look,
    /// Where it is; x above 0.
    pub at: [f64; 2],
    /// What x may be as well: a bar through the mark.
    pub span: [f64; 2],
    /// Radius in pixels.
    pub radius: f64,
    /// What who hovers over it reads.
    pub title: String,
}

/// A plot of marks of which less is better on both axes.
#[derive(Clone, Debug)]
pub struct ScatterPlot {
    /// What is written above it.
    pub title: String,
    /// What it shows, for who cannot see it.
    pub description: String,
    /// x and y.
    pub axes: [Axis; 2],
    /// Whether values of y below [`EXACT`](super::super::units::EXACT) have a strip at the foot.
    pub strip: bool,
    /// The marks.
    pub marks: Vec<Mark>,
}

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 320.0;
/// Borders of the area of the axes.
const AREA: Rectangle = [50.0, 46.0, WIDTH - 14.0, HEIGHT - 40.0];

impl ScatterPlot {
    /// Draws the plot into a page.
    pub fn draw(&self, markup: &mut Markup) {
        draw_picture(markup, [WIDTH, HEIGHT], &self.description, |svg| {
            self.content(svg)
        });
    }

    fn content(&self, svg: &mut Markup) {
        let frame = Frame::new(AREA, self.axes.clone(), self.strip);
        svg.inline(
            "text",
            &[("class", &"title"), ("x", &Px(2.0)), ("y", &17)],
            &self.title,
        );
        let marks: Vec<&Mark> = self
            .marks
            .iter()
            .filter(|mark| frame.shows(mark.at[1]))
            .collect();
        let points: Vec<[f64; 2]> = marks
            .iter()
            .map(|mark| [mark.at[0], shown(mark.at[1])])
            .collect();
        let front = pareto::front(&points);
        let places: Vec<[f64; 2]> = marks
            .iter()
            .map(|mark| [frame.x(mark.at[0]), frame.y(mark.at[1])])
            .collect();
        // Tinted first, so that the grid stays visible on it.
        if let Some([line, beaten]) = staircase(&front, &places) {
            svg.leaf("path", &[("class", &"beaten"), ("d", &beaten)]);
            frame.draw(svg);
            svg.leaf("path", &[("class", &"front"), ("d", &line)]);
        } else {
            frame.draw(svg);
        }
        for (mark, place) in marks.iter().zip(&places) {
            draw_mark(
                svg,
                mark,
                *place,
                [mark.span[0], mark.span[1]].map(|x| frame.x(x)),
            );
        }
        draw_names(svg, &marks, &places, &front);
    }
}

/// The stairs through the marks of the front, and the area beyond, where something is faster and closer.
fn staircase(front: &[usize], places: &[[f64; 2]]) -> Option<[String; 2]> {
    let [_, top, right, _] = AREA;
    let first = places[*front.first()?];
    let mut stairs = format!("M{} {}", Px(first[0]), Px(top));
    for &index in front {
        let [x, y] = places[index];
        stairs += &format!("H{}V{}", Px(x), Px(y));
    }
    stairs += &format!("H{}", Px(right));
    let beaten = format!("{stairs}V{}z", Px(top));
    Some([stairs, beaten])
}

fn draw_mark(svg: &mut Markup, mark: &Mark, place: [f64; 2], span: [f64; 2]) {
    let look = &mark.look;
    let class = if look.is_dashed {
        "mark hollow"
    } else {
        "mark"
    };
    svg.element(
        "g",
        &[("class", &class), ("style", &look.style())],
        |group| {
            // Shorter bars are within the mark.
            if span[1] - span[0] > 2.0 * mark.radius {
                let bar = format!("M{} {}H{}", Px(span[0]), Px(place[1]), Px(span[1]));
                group.leaf("path", &[("class", &"bar"), ("d", &bar)]);
            }
            look.shape.draw(group, place, mark.radius, &mark.title);
        },
    );
}

/// The names of the marks on the front, near their marks, where they cover little.
fn draw_names(svg: &mut Markup, marks: &[&Mark], places: &[[f64; 2]], front: &[usize]) {
    let mut taken: Vec<Rectangle> = places
        .iter()
        .zip(marks)
        .map(|([x, y], mark)| {
            let half = mark.radius + 1.0;
            [x - half, y - half, x + half, y + half]
        })
        .collect();
    // The stairs are thin, but letters across them are hard to read.
    for pair in front.windows(2) {
        let [[x, y], [next, below]] = [places[pair[0]], places[pair[1]]];
        taken.push([x, y - 2.0, next, y + 2.0]);
        taken.push([next - 2.0, y, next + 2.0, below]);
    }
    if let Some([x, y]) = front.last().map(|&last| places[last]) {
        taken.push([x, y - 2.0, AREA[2], y + 2.0]);
    }
    for &index in front {
        let (mark, [x, y]) = (marks[index], places[index]);
        let name = labels::shortened(&mark.name);
        let place = labels::place(&name, [x, y], mark.radius, &AREA, &taken);
        taken.push(place.covers);
        svg.element("g", &[("style", &mark.look.style())], |group| {
            if place.is_far {
                let [left, top, right, bottom] = place.covers;
                let end = [x.clamp(left, right), y.clamp(top, bottom)];
                let path = format!("M{} {}L{} {}", Px(x), Px(y), Px(end[0]), Px(end[1]));
                group.leaf("path", &[("class", &"lead"), ("d", &path)]);
            }
            let [x, y] = place.at.map(Px);
            group.inline("text", &[("class", &"name"), ("x", &x), ("y", &y)], &name);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::markup::tests::assert_well_formed;
    use super::super::super::units;
    use super::super::marks::Shape;
    use super::*;

    #[test]
    fn only_the_front_is_named_and_the_stairs_go_through_it() {
        let mark = |name: &str, x: f64, y: f64| Mark {
            name: name.to_owned(),
            look: Look {
                colour: "var(--h0)".to_owned(),
                shape: Shape::Diamond,
                is_dashed: false,
            },
            at: [x, y],
            span: [x, x],
            radius: 4.0,
            title: format!("title of {name}"),
        };
        let axis = |range| Axis {
            label: String::new(),
            range,
            ticks: Vec::new(),
            name: units::plain,
        };
        let plot = ScatterPlot {
            title: "σ".to_owned(),
            description: "d".to_owned(),
            axes: [axis([1.0, 100.0]), axis([1e-3, 1.0])],
            strip: true,
            marks: vec![
                mark("fast", 1.0, 0.5),
                mark("beaten", 20.0, 0.6),
                mark("exact", 100.0, 0.0),
                mark("unknown", 10.0, f64::NAN),
            ],
        };
        let mut markup = Markup::new();
        plot.draw(&mut markup);
        let svg = markup.into_string();
        assert_well_formed(&svg);
        let names = |name: &str| svg.contains(&format!(">{name}</text>"));
        assert!(names("fast") && names("exact") && !names("beaten"));
        assert!(svg.contains("title of beaten") && !svg.contains("title of unknown"));
        let stairs = format!("V{}H{}", Px(AREA[3] - 10.0), Px(AREA[2]));
        assert!(svg.contains(&stairs), "{stairs} in {svg}");
        assert!(!svg.contains("NaN"));
    }
}
