//! Plots on two logarithmic axes, as SVG written by hand.

use std::fmt::{self, Write};

/// A line of a plot.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name, written where the line ends.
    pub name: String,
    /// Colour, as CSS has it.
    pub colour: &'static str,
    /// Points, rising in x, all coordinates above 0.
    pub points: Vec<[f64; 2]>,
}

/// A plot on two logarithmic axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What is written above it.
    pub title: String,
    /// What is written at each axis.
    pub axes: [&'static str; 2],
    /// Ticks along x, each with its label.
    pub ticks: Vec<(f64, String)>,
    /// Lines; y is proportional to x along a dashed line through the first point of the first.
    pub series: Vec<Series>,
}

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 460.0;
/// Borders of the area of the axes: left, top, right, bottom.
const AREA: [f64; 4] = [76.0, 52.0, 590.0, 400.0];
/// Least distance of two names, in pixels.
const LINE: f64 = 17.0;

impl Plot {
    /// The plot as an SVG document of 720 × 460 pixels.
    ///
    /// # Panics
    /// If there is no point.
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("a string takes any text");
        svg
    }

    fn draw(&self, svg: &mut String) -> fmt::Result {
        let [left, top, right, bottom] = AREA;
        let scale = Scale::new(self);
        write!(
            svg,
            r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}">
<style>text{{font:13px sans-serif;fill:#333}} .grid{{stroke:#e4e4e4}} .line{{fill:none;stroke-width:2}}</style>
<rect width="100%" height="100%" fill="#fff"/>
<text x="{left}" y="26" style="font-size:15px;font-weight:bold">{}</text>
<text x="{left}" y="44" style="fill:#666">{}</text>
<text x="{right}" y="{}" text-anchor="end">{}</text>
"##,
            self.title,
            self.axes[1],
            bottom + 42.0,
            self.axes[0],
        )?;
        for decade in scale.least[1] as i32..=scale.most[1] as i32 {
            let y = scale.y(10_f64.powi(decade));
            let label = if (-3..4).contains(&decade) {
                format!("{}", 10_f64.powi(decade))
            } else {
                format!("1e{decade}")
            };
            writeln!(
                svg,
                r#"<path class="grid" d="M{left} {y:.1}H{right}"/><text x="{}" y="{:.1}" text-anchor="end">{label}</text>"#,
                left - 8.0,
                y + 4.5,
            )?;
        }
        for (tick, label) in &self.ticks {
            let x = scale.x(*tick);
            writeln!(
                svg,
                r#"<path class="grid" d="M{x:.1} {top}V{bottom}"/><text x="{x:.1}" y="{}" text-anchor="middle">{label}</text>"#,
                bottom + 20.0,
            )?;
        }
        self.draw_proportional(svg, &scale)?;
        for series in &self.series {
            let colour = series.colour;
            let points: Vec<_> = series
                .points
                .iter()
                .map(|&[x, y]| format!("{:.1},{:.1}", scale.x(x), scale.y(y)))
                .collect();
            writeln!(
                svg,
                r#"<polyline class="line" stroke="{colour}" points="{}"/>"#,
                points.join(" ")
            )?;
            for &[x, y] in &series.points {
                let (x, y) = (scale.x(x), scale.y(y));
                writeln!(
                    svg,
                    r#"<circle cx="{x:.1}" cy="{y:.1}" r="3.5" fill="{colour}"/>"#
                )?;
            }
        }
        self.draw_names(svg, &scale)?;
        svg.write_str("</svg>\n")
    }

    /// The dashed line along which y is proportional to x.
    fn draw_proportional(&self, svg: &mut String, scale: &Scale) -> fmt::Result {
        let [x, y] = self.series[0].points[0];
        let [first, last] = [scale.least[0], scale.most[0]].map(|exponent| 10_f64.powf(exponent));
        writeln!(
            svg,
            r##"<path d="M{:.1} {:.1}L{:.1} {:.1}" stroke="#999" stroke-dasharray="5 4"/>"##,
            scale.x(first),
            scale.y(y * first / x),
            scale.x(last),
            scale.y(y * last / x),
        )
    }

    /// Names at the ends of their lines, from the top, none upon another.
    fn draw_names(&self, svg: &mut String, scale: &Scale) -> fmt::Result {
        let [x, y] = self.series[0].points[0];
        let last = 10_f64.powf(scale.most[0]);
        let mut names: Vec<_> = self
            .series
            .iter()
            .filter_map(|series| {
                let [_, y] = series.points.last()?;
                Some((scale.y(*y), series.name.as_str(), series.colour))
            })
            .collect();
        names.push((scale.y(y * last / x), "proportional", "#888"));
        names.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut least = AREA[1];
        for (y, name, colour) in names {
            let y = y.max(least);
            least = y + LINE;
            writeln!(
                svg,
                r#"<text x="{}" y="{:.1}" style="fill:{colour}">{name}</text>"#,
                AREA[2] + 12.0,
                y + 4.5,
            )?;
        }
        Ok(())
    }
}

/// Decimal exponents at the borders of the axes.
struct Scale {
    least: [f64; 2],
    most: [f64; 2],
}

impl Scale {
    /// From the first point to the last along x, whole decades along y.
    fn new(plot: &Plot) -> Self {
        let all = || plot.series.iter().flat_map(|series| &series.points);
        let range = |axis: usize| {
            let exponents = || all().map(|point| point[axis].log10());
            [
                exponents().reduce(f64::min).expect("a plot has points"),
                exponents().reduce(f64::max).expect("a plot has points"),
            ]
        };
        let [[left, right], [low, high]] = [range(0), range(1)];
        // A lone point has room as well.
        let room = if left == right { 0.5 } else { 0.0 };
        Self {
            least: [left - room, low.floor()],
            most: [right + room, high.ceil().max(low.floor() + 1.0)],
        }
    }

    fn x(&self, x: f64) -> f64 {
        let share = (x.log10() - self.least[0]) / (self.most[0] - self.least[0]);
        AREA[0] + share * (AREA[2] - AREA[0])
    }

    fn y(&self, y: f64) -> f64 {
        let share = (y.log10() - self.least[1]) / (self.most[1] - self.least[1]);
        AREA[3] - share * (AREA[3] - AREA[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_proportional_lies_on_the_dashed_line_and_names_apart() {
        let series = |name: &str, factor: f64| Series {
            name: name.to_owned(),
            colour: "#000",
            points: vec![[1e6, factor], [1e8, factor * 100.0]],
        };
        let plot = Plot {
            title: "T".to_owned(),
            axes: ["x", "y"],
            ticks: vec![(1e6, "1 M".to_owned())],
            series: vec![series("a", 0.1), series("b", 0.09)],
        };
        let svg = plot.to_svg();
        // From a tenth, a decade above the lowest of 1e-2 to 1e1, to its highest.
        let third = AREA[3] - (AREA[3] - AREA[1]) / 3.0;
        let line = format!("M{:.1} {third:.1}L{:.1} {:.1}", AREA[0], AREA[2], AREA[1]);
        assert!(svg.contains(&line), "{line} in {svg}");
        let points = format!("{:.1},{third:.1} {:.1},{:.1}", AREA[0], AREA[2], AREA[1]);
        assert!(svg.contains(&points), "{points} in {svg}");
        for (name, place) in [("a", 0.0), ("proportional", 1.0), ("b", 2.0)] {
            let text = format!("y=\"{:.1}\"", AREA[1] + place * LINE + 4.5);
            let line = svg.lines().find(|line| line.contains(&format!(">{name}<")));
            assert!(
                line.is_some_and(|line| line.contains(&text)),
                "{name}: {svg}"
            );
        }
    }
}
