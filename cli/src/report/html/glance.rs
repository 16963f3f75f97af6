//! A panel in one table: error and time by contestant and size.

use super::super::markup::Markup;
use super::super::panel::Panel;
use super::super::plot::marks::Looks;
use super::super::units;
use super::legend::draw_key;

/// Draws the table of square footprints and found half vectors, cells on the Pareto front tinted.
pub fn draw(section: &mut Markup, panel: &Panel<'_>, looks: &Looks<'_>) {
    let sizes = panel.sizes(1.0);
    let fronts: Vec<Vec<usize>> = sizes.iter().map(|&sigma| panel.front(sigma, 1.0)).collect();
    section.element("div", &[("class", &"scroll")], |scroll| {
        scroll.element(
            "table",
            &[("class", &"glance"), ("aria-label", &panel.title())],
            |table| {
                table.element("thead", &[], |head| {
                    head.element("tr", &[], |row| {
                        row.inline(
                            "th",
                            &[("scope", &"col"), ("class", &"first")],
                            "error and time of an eval",
                        );
                        for sigma in &sizes {
                            row.inline(
                                "th",
                                &[("scope", &"col")],
                                format_args!("σ {}", units::plain(*sigma)),
                            );
                        }
                        row.inline("th", &[("scope", &"col")], "bytes a texel");
                        row.inline("th", &[("scope", &"col")], "bake");
                    });
                });
                table.element("tbody", &[], |body| {
                    for (index, contestant) in panel.contestants.iter().enumerate() {
                        body.element("tr", &[], |row| {
                            row.element("th", &[("scope", &"row")], |name| {
                                draw_key(name, looks.of(contestant));
                                name.text(format_args!(" {}", contestant.name()));
                            });
                            for (sigma, front) in sizes.iter().zip(&fronts) {
                                let class = if front.contains(&index) { "on" } else { "off" };
                                row.element("td", &[("class", &class)], |cell| {
                                    let Some(found) = panel.found(contestant, *sigma, 1.0) else {
                                        return cell.text("–");
                                    };
                                    match found.truth.relative_l1 {
                                        Some(error) => {
                                            cell.text(format_args!("{} %", units::percent(error)))
                                        }
                                        None => cell.text("–"),
                                    }
                                    cell.inline(
                                        "small",
                                        &[],
                                        units::time(found.times.eval.median_ns),
                                    );
                                });
                            }
                            match panel.package(contestant) {
                                Some(package) => {
                                    row.inline(
                                        "td",
                                        &[],
                                        units::significant(package.bytes_per_texel, 3),
                                    );
                                    row.inline("td", &[], units::seconds(package.bake_seconds));
                                }
                                None => {
                                    row.inline("td", &[], "–");
                                    row.inline("td", &[], "–");
                                }
                            }
                        });
                    }
                });
            },
        );
    });
    section.element("p", &[("class", &"facts")], |p| {
        p.text("Square footprints, half vectors drawn from the truth. Tinted: on the Pareto front of that size.");
    });
    section.end_line();
}
