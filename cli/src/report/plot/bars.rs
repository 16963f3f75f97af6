//! Plots of bars, one for each contestant.

use super::super::markup::{Markup, Px};
use super::draw_picture;
use super::labels;
use super::marks::Look;

/// A bar.
#[derive(Clone, Debug)]
pub struct Bar {
    /// Name, written left of it.
    pub name: String,
    /// How it looks.
    pub look: Look,
    /// How long it is, from 0.
    pub value: f64,
    /// What is written right of it.
    pub text: String,
}

/// A plot of bars from zero on a linear axis.
#[derive(Clone, Debug)]
pub struct BarPlot {
    /// What is written above it.
    pub title: String,
    /// What it shows, for who cannot see it.
    pub description: String,
    /// The bars, from the top.
    pub bars: Vec<Bar>,
}

const WIDTH: f64 = 600.0;
const TOP: f64 = 34.0;
/// Height of a bar with the space below it.
const STEP: f64 = 22.0;
const THICKNESS: f64 = 13.0;
/// Room for what is written right of the longest bar.
const RIGHT: f64 = 76.0;

impl BarPlot {
    /// Draws the plot into a page.
    pub fn draw(&self, markup: &mut Markup) {
        let height = TOP + STEP * self.bars.len() as f64 + 6.0;
        draw_picture(markup, [WIDTH, height], &self.description, |svg| {
            self.content(svg)
        });
    }

    fn content(&self, svg: &mut Markup) {
        svg.inline(
            "text",
            &[("class", &"title"), ("x", &2), ("y", &17)],
            &self.title,
        );
        let names = self
            .bars
            .iter()
            .map(|bar| labels::width(&labels::shortened(&bar.name)));
        let left = 10.0 + names.fold(0.0, f64::max);
        let most = self.bars.iter().map(|bar| bar.value).fold(0.0, f64::max);
        for (place, bar) in self.bars.iter().enumerate() {
            let y = TOP + STEP * place as f64;
            // Everything is 0 if the longest is.
            let share = if most > 0.0 { bar.value / most } else { 0.0 };
            let length = (WIDTH - RIGHT - left) * share;
            let (base, name) = (Px(y + THICKNESS - 2.5), labels::shortened(&bar.name));
            svg.inline(
                "text",
                &[
                    ("x", &Px(left - 8.0)),
                    ("y", &base),
                    ("text-anchor", &"end"),
                ],
                name,
            );
            let class = if bar.look.is_dashed {
                "mark hollow"
            } else {
                "mark"
            };
            svg.element(
                "g",
                &[("class", &class), ("style", &bar.look.style())],
                |group| {
                    group.leaf(
                        "rect",
                        &[
                            ("x", &Px(left)),
                            ("y", &Px(y)),
                            ("width", &Px(length.max(1.0))),
                            ("height", &Px(THICKNESS)),
                            ("rx", &2),
                        ],
                    );
                },
            );
            let x = Px(left + length.max(1.0) + 6.0);
            svg.inline(
                "text",
                &[("class", &"value"), ("x", &x), ("y", &base)],
                &bar.text,
            );
        }
        let path = format!(
            "M{} {}V{}",
            Px(left),
            Px(TOP - 4.0),
            Px(TOP + STEP * self.bars.len() as f64 - 3.0)
        );
        svg.leaf("path", &[("class", &"axis"), ("d", &path)]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::markup::tests::assert_well_formed;
    use super::super::marks::Shape;
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_values_and_none_is_invisible() {
        let bar = |value: f64| Bar {
            name: "<n>".to_owned(),
            look: Look {
                colour: "red".to_owned(),
                shape: Shape::Circle,
                is_dashed: false,
            },
            value,
            text: value.to_string(),
        };
        let plot = BarPlot {
            title: "T".to_owned(),
            description: "d".to_owned(),
            bars: vec![bar(4.0), bar(2.0), bar(0.0)],
        };
        let mut markup = Markup::new();
        plot.draw(&mut markup);
        let svg = markup.into_string();
        assert_well_formed(&svg);
        let widths: Vec<f64> = svg
            .split("width=\"")
            .skip(1)
            .filter_map(|text| text.split('"').next()?.parse().ok())
            .collect();
        assert!((widths[0] - 2.0 * widths[1]).abs() < 0.2, "{widths:?}");
        assert_eq!(widths[2], 1.0);
    }
}
