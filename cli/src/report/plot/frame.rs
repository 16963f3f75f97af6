//! The frame of a plot on two logarithmic axes: its area, grid, ticks and the strip for what is exact.

use super::super::markup::{Markup, Px};
use super::super::units::EXACT;
use super::labels::Rectangle;
use super::scale::{LogScale, Ticks};

/// Height of the strip for what is exact.
const STRIP: f64 = 20.0;

/// What an axis shows.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, with its unit.
    pub label: String,
    /// Least and largest value, above 0.
    pub range: [f64; 2],
    /// Values with their names; round ones are found if there are none.
    pub ticks: Vec<(f64, String)>,
    /// How a round value is named.
    pub name: fn(f64) -> String,
}

/// A plot's area with its scales.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Left, top, right and bottom of the axes.
    pub area: Rectangle,
    axes: [Axis; 2],
    x: LogScale,
    y: LogScale,
    /// Whether values below [`EXACT`] have a strip at the foot.
    strip: bool,
}

impl Frame {
    /// The frame of `axes`, x and y, in `area`; with a strip for values of y below [`EXACT`] if `strip`.
    pub fn new(area: Rectangle, axes: [Axis; 2], strip: bool) -> Self {
        let [left, top, right, bottom] = area;
        let foot = if strip { bottom - STRIP } else { bottom };
        let x = LogScale::new(axes[0].range, [left, right]);
        let y = LogScale::new(axes[1].range, [foot, top]);
        Self {
            area,
            axes,
            x,
            y,
            strip,
        }
    }

    /// The pixel of `x`, which must be above 0.
    pub fn x(&self, x: f64) -> f64 {
        self.x.at(x)
    }

    /// The pixel of `y`; what is exact, or no number above 0, is in the middle of the strip if there is one.
    pub fn y(&self, y: f64) -> f64 {
        if self.strip && y < EXACT {
            self.area[3] - STRIP / 2.0
        } else {
            self.y.at(y)
        }
    }

    /// Whether a point at `y` has a place.
    pub fn shows(&self, y: f64) -> bool {
        y.is_finite() && (y > 0.0 || self.strip)
    }

    /// Draws grid, ticks, names and the strip.
    pub fn draw(&self, markup: &mut Markup) {
        let [left, top, right, bottom] = self.area;
        let foot = if self.strip { bottom - STRIP } else { bottom };
        let (across, up) = (self.named(0, 58.0), self.named(1, 30.0));
        let mut faint = String::new();
        for value in &across.1 {
            faint += &format!("M{} {}V{}", Px(self.x(*value)), Px(top), Px(bottom));
        }
        for value in &up.1 {
            faint += &format!("M{} {}H{}", Px(left), Px(self.y.at(*value)), Px(right));
        }
        markup.leaf("path", &[("class", &"faint"), ("d", &faint)]);
        let mut grid = String::new();
        for (value, _) in &across.0 {
            grid += &format!("M{} {}V{}", Px(self.x(*value)), Px(top), Px(bottom));
        }
        for (value, _) in &up.0 {
            grid += &format!("M{} {}H{}", Px(left), Px(self.y.at(*value)), Px(right));
        }
        markup.leaf("path", &[("class", &"grid"), ("d", &grid)]);
        if self.strip {
            let (width, y) = (Px(right - left), Px(foot));
            let height = Px(STRIP);
            markup.leaf(
                "rect",
                &[
                    ("class", &"strip"),
                    ("x", &Px(left)),
                    ("y", &y),
                    ("width", &width),
                    ("height", &height),
                ],
            );
            self.tick(
                markup,
                [left - 6.0, bottom - STRIP / 2.0 + 4.0],
                "end",
                "exact",
            );
        }
        let border = format!("M{} {}V{}H{}", Px(left), Px(top), Px(bottom), Px(right));
        markup.leaf("path", &[("class", &"axis"), ("d", &border)]);
        for (value, name) in &across.0 {
            self.tick(markup, [self.x(*value), bottom + 15.0], "middle", name);
        }
        for (value, name) in &up.0 {
            let y = self.y.at(*value) + 4.0;
            // A name at the very foot would run into the strip's.
            if !(self.strip && y > foot) {
                self.tick(markup, [left - 6.0, y], "end", name);
            }
        }
        let label = |markup: &mut Markup, [x, y]: [f64; 2], anchor: &str, text: &str| {
            markup.inline(
                "text",
                &[
                    ("class", &"label"),
                    ("x", &Px(x)),
                    ("y", &Px(y)),
                    ("text-anchor", &anchor),
                ],
                text,
            );
        };
        label(markup, [right, bottom + 31.0], "end", &self.axes[0].label);
        label(
            markup,
            [left - 48.0, top - 9.0],
            "start",
            &self.axes[1].label,
        );
    }

    fn tick(&self, markup: &mut Markup, [x, y]: [f64; 2], anchor: &str, text: &str) {
        markup.inline(
            "text",
            &[("x", &Px(x)), ("y", &Px(y)), ("text-anchor", &anchor)],
            text,
        );
    }

    /// Values with names, and values without, of an axis whose names take `pixels` each.
    fn named(&self, axis: usize, pixels: f64) -> (Vec<(f64, String)>, Vec<f64>) {
        let Axis { ticks, name, .. } = &self.axes[axis];
        if !ticks.is_empty() {
            return (ticks.clone(), Vec::new());
        }
        let [left, top, right, bottom] = self.area;
        let (scale, length) = if axis == 0 {
            (&self.x, right - left)
        } else {
            (&self.y, bottom - top)
        };
        let Ticks { named, faint } = scale.ticks((length / pixels) as usize + 1);
        (
            named
                .into_iter()
                .map(|value| (value, name(value)))
                .collect(),
            faint,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::units;
    use super::*;

    #[test]
    fn zero_has_a_place_below_every_other() {
        let axis = |range| Axis {
            label: String::new(),
            range,
            ticks: Vec::new(),
            name: units::percent_tick,
        };
        let area = [50.0, 20.0, 300.0, 200.0];
        let frame = Frame::new(area, [axis([1.0, 10.0]), axis([1e-4, 1.0])], true);
        assert!(frame.y(1e-4) <= 180.0 && frame.y(1.0) == 20.0);
        assert_eq!(frame.y(0.0), 190.0);
        assert_eq!(frame.y(1e-9), 190.0);
        assert!(frame.shows(0.0) && !frame.shows(f64::NAN));
        let bare = Frame::new(area, [axis([1.0, 10.0]), axis([1e-4, 1.0])], false);
        assert!(!bare.shows(0.0));
        assert_eq!(bare.y(1e-4), 200.0);
    }
}
