//! Plots of lines, each with its name at its end.

use super::super::markup::{Markup, Px};
use super::draw_picture;
use super::frame::{Axis, Frame};
use super::labels;
use super::marks::{Look, Shape};
use super::scale;

/// A line of a plot.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name, written where the line ends.
    pub name: String,
    /// How it looks.
    pub look: Look,
    /// Points, rising in x.
    pub points: Vec<Point>,
}

/// A point of a line.
#[derive(Clone, Debug)]
pub struct Point {
    /// Where it is; x above 0.
    pub at: [f64; 2],
    /// What y may be as well: a bar through the point.
    pub span: Option<[f64; 2]>,
    /// What who hovers over it reads.
    pub title: String,
}

impl Series {
    /// A line through `points` without bars and titles, in the CSS colour `colour`.
    pub fn new(name: impl Into<String>, colour: impl Into<String>, points: &[[f64; 2]]) -> Self {
        Self {
            name: name.into(),
            look: Look {
                colour: colour.into(),
                shape: Shape::Circle,
                is_dashed: false,
            },
            points: points
                .iter()
                .map(|at| Point {
                    at: *at,
                    span: None,
                    title: String::new(),
                })
                .collect(),
        }
    }
}

/// A plot of lines on two logarithmic axes.
#[derive(Clone, Debug)]
pub struct LinePlot {
    /// What is written above it.
    pub title: String,
    /// What it shows, for who cannot see it.
    pub description: String,
    /// x and y.
    pub axes: [Axis; 2],
    /// Whether values of y below [`EXACT`](super::super::units::EXACT) have a strip at the foot.
    pub strip: bool,
    /// Whether a dashed line, proportional to x through the first point of the first series, is drawn.
    pub proportional: bool,
    /// The lines.
    pub series: Vec<Series>,
}

const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 380.0;
const TOP: f64 = 50.0;
/// Border of a document of its own.
const BORDER: f64 = 12.0;
/// Left and bottom of the area of the axes.
const LEFT: f64 = 50.0;
const BOTTOM: f64 = HEIGHT - 42.0;

/// What a page's style sheet says otherwise.
const STYLE: &str = "text{font:11px system-ui,sans-serif;fill:#4a5059}.title{font-size:13px;font-weight:600;fill:#15181d}\
.label{fill:#6b727c}.grid,.faint{fill:none;stroke:#dfe3e8}.faint{stroke:#f0f2f5}.axis{fill:none;stroke:#9aa1ab}\
.line{fill:none;stroke:currentColor;stroke-width:1.8;stroke-linejoin:round}.mark{fill:currentColor}\
.lead{fill:none;stroke:currentColor;stroke-opacity:.5}.name{fill:currentColor;font-weight:500}\
.reference{fill:none;stroke:#8a919b;stroke-dasharray:5 4}.dashed{stroke-dasharray:6 4}\
.hollow{fill:#fff;stroke:currentColor;stroke-width:1.8}.bar{fill:none;stroke:currentColor;stroke-opacity:.55}\
.strip{fill:#0b5fa5;fill-opacity:.09}";

impl LinePlot {
    /// The plot as an SVG document of its own, dark on white.
    pub fn to_svg(&self) -> String {
        let mut markup = Markup::new();
        // A document has a border of its own, in a page the page has.
        let (width, height) = (WIDTH + 2.0 * BORDER, HEIGHT + BORDER);
        let size = format!("-{BORDER} -{BORDER} {width} {height}");
        markup.element(
            "svg",
            &[
                ("xmlns", &"http://www.w3.org/2000/svg"),
                ("viewBox", &size),
                ("width", &width),
                ("height", &height),
                ("role", &"img"),
                ("aria-label", &self.description),
            ],
            |svg| {
                svg.element("style", &[], |style| style.trusted(STYLE));
                let corner = -BORDER;
                svg.leaf(
                    "rect",
                    &[
                        ("x", &corner),
                        ("y", &corner),
                        ("width", &width),
                        ("height", &height),
                        ("fill", &"#fff"),
                    ],
                );
                self.content(svg);
            },
        );
        markup.end_line();
        markup.into_string()
    }

    /// Draws the plot into a page.
    pub fn draw(&self, markup: &mut Markup) {
        draw_picture(markup, [WIDTH, HEIGHT], &self.description, |svg| {
            self.content(svg)
        });
    }

    fn content(&self, svg: &mut Markup) {
        let longest = self
            .series
            .iter()
            .map(|series| labels::width(&labels::shortened(&series.name)));
        let right = WIDTH - 22.0 - longest.fold(labels::width("proportional"), f64::max);
        let frame = Frame::new([LEFT, TOP, right, BOTTOM], self.axes.clone(), self.strip);
        svg.inline(
            "text",
            &[("class", &"title"), ("x", &Px(2.0)), ("y", &20)],
            &self.title,
        );
        frame.draw(svg);
        let reference = self.reference(&frame);
        if let Some([from, to]) = reference {
            let path = format!(
                "M{} {}L{} {}",
                Px(from[0]),
                Px(from[1]),
                Px(to[0]),
                Px(to[1])
            );
            svg.leaf("path", &[("class", &"reference"), ("d", &path)]);
        }
        for series in &self.series {
            draw_series(svg, &frame, series);
        }
        self.draw_names(svg, &frame, reference);
    }

    /// Both ends of the dashed line along which y is proportional to x, cut off at the top and the foot.
    fn reference(&self, frame: &Frame) -> Option<[[f64; 2]; 2]> {
        if !self.proportional {
            return None;
        }
        let [x, y] = self.series.first()?.points.first()?.at;
        let ([left, right], [low, high]) = (self.axes[0].range, self.axes[1].range);
        let ends = [left.max(x * low / y), right.min(x * high / y)];
        Some(ends.map(|end| [frame.x(end), frame.y(y * end / x)]))
    }

    /// Names at the ends of their lines, none upon another, each led to its line if it had to move.
    fn draw_names(&self, svg: &mut Markup, frame: &Frame, reference: Option<[[f64; 2]; 2]>) {
        let mut ends: Vec<([f64; 2], &str, &str)> = Vec::new();
        for series in &self.series {
            let shown = |point: &&Point| frame.shows(point.at[1]);
            if let Some(point) = series.points.iter().rev().find(shown) {
                let [x, y] = point.at;
                ends.push(([frame.x(x), frame.y(y)], &series.name, &series.look.colour));
            }
        }
        if let Some([_, end]) = reference {
            ends.push((end, "proportional", "#8a919b"));
        }
        let [_, top, right, bottom] = frame.area;
        let wanted: Vec<f64> = ends.iter().map(|end| end.0[1]).collect();
        let heights = labels::spread(&wanted, labels::LINE, [top, bottom]);
        for ((end, name, colour), height) in ends.into_iter().zip(heights) {
            let style = format!("color:{colour}");
            svg.element("g", &[("style", &style)], |group| {
                let path = format!(
                    "M{} {}L{} {}",
                    Px(end[0] + 5.0),
                    Px(end[1]),
                    Px(right + 9.0),
                    Px(height)
                );
                group.leaf("path", &[("class", &"lead"), ("d", &path)]);
                group.inline(
                    "text",
                    &[
                        ("class", &"name"),
                        ("x", &Px(right + 12.0)),
                        ("y", &Px(height + 4.0)),
                    ],
                    labels::shortened(name),
                );
            });
        }
    }
}

fn draw_series(svg: &mut Markup, frame: &Frame, series: &Series) {
    let look = &series.look;
    let shown = || {
        series
            .points
            .iter()
            .filter(|point| frame.shows(point.at[1]))
    };
    svg.element("g", &[("style", &look.style())], |group| {
        let mut line = String::new();
        let mut bars = String::new();
        for point in shown() {
            let [x, y] = [frame.x(point.at[0]), frame.y(point.at[1])];
            line += &format!(
                "{}{} {}",
                if line.is_empty() { 'M' } else { 'L' },
                Px(x),
                Px(y)
            );
            if let Some([low, high]) = point.span {
                let [low, high] = [frame.y(low), frame.y(high)];
                // Shorter ones are within the mark.
                if low - high > 8.0 {
                    bars += &format!("M{} {}V{}", Px(x), Px(low), Px(high));
                }
            }
        }
        let class = if look.is_dashed {
            "line dashed"
        } else {
            "line"
        };
        group.leaf("path", &[("class", &class), ("d", &line)]);
        if !bars.is_empty() {
            group.leaf("path", &[("class", &"bar"), ("d", &bars)]);
        }
        let class = if look.is_dashed {
            "mark hollow"
        } else {
            "mark"
        };
        group.element("g", &[("class", &class)], |marks| {
            for point in shown() {
                let at = [frame.x(point.at[0]), frame.y(point.at[1])];
                look.shape.draw(marks, at, 3.4, &point.title);
            }
        });
    });
}

/// The range of y that shows every point and bar of `series`, with a little room; `None` if none has a logarithm.
pub fn range_of<'a>(series: impl Iterator<Item = &'a Series>) -> Option<[f64; 2]> {
    let values = series.flat_map(|series| &series.points).flat_map(|point| {
        let [low, high] = point.span.unwrap_or([point.at[1]; 2]);
        [point.at[1], low, high]
    });
    scale::range(values).map(|range| scale::padded(range, 0.05))
}

#[cfg(test)]
mod tests {
    use super::super::super::markup::tests::assert_well_formed;
    use super::super::super::units;
    use super::*;

    fn axis(range: [f64; 2]) -> Axis {
        Axis {
            label: "<x>".to_owned(),
            range,
            ticks: Vec::new(),
            name: units::plain,
        }
    }

    #[test]
    fn what_is_proportional_lies_on_the_dashed_line_and_names_apart() {
        let plot = LinePlot {
            title: "T".to_owned(),
            description: "t".to_owned(),
            axes: [axis([1e6, 1e8]), axis([1e-2, 1e1])],
            strip: false,
            proportional: true,
            series: vec![
                Series::new("a", "#000", &[[1e6, 0.1], [1e8, 10.0]]),
                Series::new("b & c", "#111", &[[1e6, 0.09], [1e8, 9.0]]),
            ],
        };
        let svg = plot.to_svg();
        assert_well_formed(&svg);
        let right = WIDTH - 22.0 - labels::width("proportional");
        // From a tenth, a decade above the lowest of 1e-2 to 1e1, to its highest.
        let third = Px(BOTTOM - (BOTTOM - TOP) / 3.0);
        let line = format!("\"M{LEFT} {third}L{} {TOP}\"", Px(right));
        // Once dashed, once as the line of the first series.
        assert_eq!(svg.matches(&line).count(), 2, "{line} in {svg}");
        let heights: Vec<f64> = svg
            .split("class=\"name\"")
            .skip(1)
            .filter_map(|text| text.split("y=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        assert_eq!(heights.len(), 3);
        for (index, one) in heights.iter().enumerate() {
            for other in &heights[..index] {
                assert!((one - other).abs() > labels::LINE - 0.2, "{heights:?}");
            }
        }
    }

    #[test]
    fn points_without_a_logarithm_are_left_out_or_in_the_strip() {
        let series = Series::new("a", "#000", &[[1.0, 0.1], [2.0, 0.0], [4.0, f64::NAN]]);
        assert!(range_of([&series].into_iter()).is_some_and(|[low, high]| low < 0.1 && high > 0.1));
        for (strip, marks) in [(false, 1), (true, 2)] {
            let plot = LinePlot {
                title: String::new(),
                description: String::new(),
                axes: [axis([1.0, 4.0]), axis([1e-3, 1.0])],
                strip,
                proportional: false,
                series: vec![series.clone()],
            };
            let svg = plot.to_svg();
            assert_eq!(svg.matches("<circle").count(), marks);
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}
