//! How contestants look: a colour, a shape, and a dash where colours begin again.

use super::super::document::{Contestant, Report, Role};
use super::super::markup::{Attributes, Markup, Px};
use std::fmt::Display;

/// Colours of methods and of what papers print: custom properties `--h0` and on of the page.
pub const HUES: usize = 8;
/// Muted colours of baselines: custom properties `--n0` and on of the page.
pub const NEUTRALS: usize = 5;

/// The shape of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Of methods.
    Circle,
    /// Of what papers print.
    Diamond,
    /// Of baselines.
    Square,
}

impl Shape {
    /// The shape of `role`.
    pub fn of(role: Role) -> Self {
        match role {
            Role::Method => Self::Circle,
            Role::Paper => Self::Diamond,
            Role::Baseline => Self::Square,
        }
    }

    /// Draws the shape with the area of a circle of `radius`, and `title` for who hovers over it, if there is one.
    pub fn draw(self, markup: &mut Markup, [x, y]: [f64; 2], radius: f64, title: &str) {
        let (x_px, y_px) = (Px(x), Px(y));
        match self {
            Self::Circle => {
                let size = Px(radius);
                titled(
                    markup,
                    "circle",
                    &[("cx", &x_px), ("cy", &y_px), ("r", &size)],
                    title,
                );
            }
            Self::Square | Self::Diamond => {
                // Half the edge of a square of equal area, or half its diagonal.
                let half = radius * 0.886;
                let path = if self == Self::Square {
                    let edge = Px(2.0 * half);
                    format!("M{} {}h{edge}v{edge}h-{edge}z", Px(x - half), Px(y - half))
                } else {
                    let half = half * core::f64::consts::SQRT_2;
                    let step = Px(half);
                    format!(
                        "M{x_px} {}l{step} {step}l-{step} {step}l-{step} -{step}z",
                        Px(y - half)
                    )
                };
                titled(markup, "path", &[("d", &path)], title);
            }
        }
    }
}

fn titled(markup: &mut Markup, name: &str, attributes: Attributes<'_>, title: &str) {
    if title.is_empty() {
        markup.leaf(name, attributes);
    } else {
        markup.element(name, attributes, |inside| {
            inside.inline("title", &[], title)
        });
    }
}

/// How one contestant looks wherever it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Colour, as CSS has it.
    pub colour: String,
    /// Shape of its marks.
    pub shape: Shape,
    /// Whether its lines are dashed and its marks hollow.
    pub is_dashed: bool,
}

impl Look {
    /// The attribute that colours an element and what is in it.
    pub fn style(&self) -> impl Display {
        format!("color:{}", self.colour)
    }
}

/// How every contestant of a report looks, the same in all its plots.
#[derive(Clone, Debug)]
pub struct Looks<'r> {
    looks: Vec<(&'r Contestant, Look)>,
}

impl<'r> Looks<'r> {
    /// Colours in the order in which contestants first appear, hues for methods and papers, muted ones for baselines.
    pub fn new(report: &'r Report) -> Self {
        let mut looks: Vec<(&Contestant, Look)> = Vec::new();
        let mut used = [0, 0];
        let contestants = report.maps.iter().flat_map(|map| {
            let baked = map.packages.iter().map(|package| &package.contestant);
            baked.chain(map.rows.iter().map(|row| &row.contestant))
        });
        for contestant in contestants {
            if looks.iter().any(|(known, _)| *known == contestant) {
                continue;
            }
            let is_baseline = contestant.role == Role::Baseline;
            let (letter, count) = if is_baseline {
                ('n', NEUTRALS)
            } else {
                ('h', HUES)
            };
            let number = &mut used[usize::from(is_baseline)];
            let look = Look {
                colour: format!("var(--{letter}{})", *number % count),
                shape: Shape::of(contestant.role),
                // The second round of colours is dashed, the third as the first: more than these no plot can show.
                is_dashed: *number / count % 2 == 1,
            };
            *number += 1;
            looks.push((contestant, look));
        }
        Self { looks }
    }

    /// How `contestant` looks.
    ///
    /// # Panics
    /// If it is not in the report.
    pub fn of(&self, contestant: &Contestant) -> &Look {
        let found = self.looks.iter().find(|(known, _)| *known == contestant);
        &found.expect("every contestant of the report has a look").1
    }
}
