//! `report.html`: one page that holds everything, without scripts and without anything from elsewhere.

mod glance;
mod head;
mod legend;
mod plots;
mod rows;
mod sources;

use super::document::{MapReport, Report};
use super::markup::Markup;
use super::panel::{Panel, panels};
use super::plot::marks::Looks;
use super::units;

/// Light and dark, screens and paper.
const STYLE: &str = include_str!("style.css");

/// The page of `report`: HTML 5, UTF-8, about 100 KB for each map, kernel, filter and roughness.
pub fn page(report: &Report) -> String {
    let looks = Looks::new(report);
    let mut page = Markup::new();
    page.trusted("<!DOCTYPE html>\n");
    page.element("html", &[("lang", &"en")], |html| {
        html.element("head", &[], |head| {
            head.leaf("meta", &[("charset", &"utf-8")]);
            head.leaf(
                "meta",
                &[
                    ("name", &"viewport"),
                    ("content", &"width=device-width, initial-scale=1"),
                ],
            );
            head.leaf(
                "meta",
                &[("name", &"color-scheme"), ("content", &"light dark")],
            );
            head.inline(
                "title",
                &[],
                format_args!("{} | glintbake report", names(report)),
            );
            head.element("style", &[], |style| style.trusted(STYLE));
        });
        html.end_line();
        html.element("body", &[], |body| {
            body.element("header", &[], |header| head::draw(header, report));
            body.element("main", &[], |main| {
                for (number, map) in report.maps.iter().enumerate() {
                    draw_map(main, map, number, &looks);
                }
                head::draw_definitions(main);
            });
            body.element("footer", &[], |footer| {
                footer.text(format_args!(
                    "Made by glintbake {}. The same numbers are in report.json and report.csv.",
                    report.head.glintbake
                ));
            });
        });
    });
    page.end_line();
    page.into_string()
}

/// The names of a few maps, for the title.
fn names(report: &Report) -> String {
    let names: Vec<&str> = report.maps.iter().map(|map| map.name.as_str()).collect();
    match names.len() {
        0..=3 => names.join(", "),
        count => format!("{} and {} more", names[0], count - 1),
    }
}

/// The anchor of a map, or of a panel of it.
fn anchor(map: usize, panel: Option<usize>) -> String {
    match panel {
        Some(panel) => format!("map-{}-{}", map + 1, panel + 1),
        None => format!("map-{}", map + 1),
    }
}

fn draw_map(main: &mut Markup, map: &MapReport, number: usize, looks: &Looks<'_>) {
    main.element(
        "section",
        &[("class", &"map"), ("id", &anchor(number, None))],
        |section| {
            section.inline("h2", &[], &map.name);
            section.element("p", &[("class", &"facts")], |facts| {
                facts.text(format_args!(
                    "{} × {} texels, BLAKE3 ",
                    map.width, map.height
                ));
                facts.inline("code", &[], &map.blake3);
            });
            for (place, panel) in panels(map).iter().enumerate() {
                draw_panel(section, panel, &anchor(number, Some(place)), looks);
            }
            if !map.sources.is_empty() {
                sources::draw(section, map);
            }
            if !map.skipped.is_empty() {
                section.inline("h3", &[], "Not measured");
                section.element("ul", &[], |list| {
                    for skipped in &map.skipped {
                        list.inline("li", &[], skipped);
                    }
                });
            }
        },
    );
    main.end_line();
}

fn draw_panel(section: &mut Markup, panel: &Panel<'_>, id: &str, looks: &Looks<'_>) {
    section.element("section", &[("class", &"panel"), ("id", &id)], |section| {
        section.inline("h3", &[], panel.title());
        glance::draw(section, panel, looks);
        legend::draw(section, panel, looks);
        let scatter = plots::scatter(panel, looks);
        if !scatter.is_empty() {
            section.inline("h4", &[], "Error against time");
            section.element("div", &[("class", &"small-plots")], |plots| {
                for plot in &scatter {
                    plot.draw(plots);
                }
            });
        }
        let lines = plots::lines(panel, looks);
        let bars = plots::bars(panel, looks);
        if !lines.is_empty() {
            section.inline("h4", &[], "Error and time against size");
            section.element("div", &[("class", &"plots")], |plots| {
                for plot in &lines {
                    plot.draw(plots);
                }
            });
        }
        if !bars.is_empty() {
            section.inline("h4", &[], "What it takes beforehand");
            section.element("div", &[("class", &"plots")], |plots| {
                for plot in &bars {
                    plot.draw(plots);
                }
            });
        }
        rows::draw(section, panel, looks);
    });
    section.end_line();
}

/// A size of footprints in words, such as `σ 16: 32 × 32 texels`.
fn size_name(sigma: f64, anisotropy: f64) -> String {
    // Half the geometric mean of the edges is σ.
    let stretch = anisotropy.sqrt();
    let [long, short] = [2.0 * sigma * stretch, 2.0 * sigma / stretch].map(edge_name);
    format!("σ {}: {long} × {short} texels", units::plain(sigma))
}

fn edge_name(edge: f64) -> String {
    if edge < 100.0 {
        units::plain(libm::round(edge * 10.0) / 10.0)
    } else {
        format!("{edge:.0}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::document::Role;
    use super::super::fixtures;
    use super::super::markup::tests::assert_well_formed;
    use super::*;

    #[test]
    fn the_page_is_well_formed_and_needs_nothing_from_elsewhere() {
        let page = page(&fixtures::report());
        assert_well_formed(&page);
        for word in ["NaN", ">inf", "\"inf", "http", "<script", "url(", "@import"] {
            assert!(!page.contains(word), "{word}");
        }
        for word in [
            "prefers-color-scheme: dark",
            "flake-bins bins-45",
            "AMD EPYC 7B13",
        ] {
            assert!(page.contains(word), "{word}");
        }
        // Every plot says what it is to who cannot see it.
        for svg in page.split("<svg").skip(1) {
            let tag = svg.split('>').next().expect("a tag");
            let is_named = tag.contains("role=\"img\"") && tag.contains("aria-label=\"");
            assert!(is_named || tag.contains("aria-hidden"), "{tag}");
        }
    }

    #[test]
    fn names_are_escaped_wherever_they_are() {
        let mut report = fixtures::report();
        let evil = "<script>alert('&')</script>.png";
        report.maps[0].name = evil.to_owned();
        report.head.command = format!("glintbake report \"{evil}\"");
        report.head.processor = evil.to_owned();
        for row in &mut report.maps[0].rows {
            row.contestant.variant += "<b>";
            row.kernel += "</p>";
        }
        for package in &mut report.maps[0].packages {
            package.contestant.variant += "<b>";
        }
        let page = page(&report);
        assert_well_formed(&page);
        assert!(!page.contains("<script") && !page.contains("<b>"));
        assert!(page.contains("&lt;script&gt;"));
    }

    #[test]
    fn a_report_without_some_or_all_of_its_numbers_is_a_page_too() {
        let mut report = fixtures::report();
        for row in &mut report.maps[0].rows {
            row.truth.relative_l1 = None;
            row.truth.worst = None;
            row.energy = None;
            row.times.eval.median_ns = 0.0;
        }
        report.maps[0].packages.clear();
        report.maps[0].sources.clear();
        report.maps.push(fixtures::map("b"));
        report.maps[1].rows.clear();
        report.complete = false;
        report.head.optimised = false;
        let all = page(&report);
        assert_well_formed(&all);
        assert!(!all.contains("NaN") && !all.contains("inf\""));
        assert!(all.contains("not complete") && all.contains("without optimisation"));
        report.maps.clear();
        assert_well_formed(&page(&report));
    }

    #[test]
    fn eight_reports_in_one_stay_below_a_few_megabytes() {
        let mut report = fixtures::report();
        report.maps = (0..4)
            .map(|number| fixtures::map(&format!("{number}.png")))
            .collect();
        let length = page(&report).len();
        assert!(length < 4_000_000, "{length} bytes");
    }

    #[test]
    fn colours_are_far_enough_from_the_ground_in_both_themes() {
        let luminance = |hex: &str| -> f64 {
            let channel = |at: usize| {
                let value = u8::from_str_radix(&hex[at..at + 2], 16).expect("two digits");
                let value = f64::from(value) / 255.0;
                if value <= 0.040_45 {
                    value / 12.92
                } else {
                    libm::pow((value + 0.055) / 1.055, 2.4)
                }
            };
            0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
        };
        let (light, dark) = STYLE
            .split_once("prefers-color-scheme: dark")
            .expect("two themes");
        for theme in [light, dark] {
            let colour = |name: &str| {
                let start = theme.find(&format!("--{name}:")).expect(name) + name.len() + 3;
                let value = theme[start..].trim_start();
                luminance(&value[..7])
            };
            let ground = colour("ground");
            let against = |name: &str| {
                let other = colour(name);
                (other.max(ground) + 0.05) / (other.min(ground) + 0.05)
            };
            let hues = (0..super::super::plot::marks::HUES).map(|number| format!("h{number}"));
            let neutrals =
                (0..super::super::plot::marks::NEUTRALS).map(|number| format!("n{number}"));
            for name in hues.chain(neutrals) {
                assert!(against(&name) >= 2.95, "{name}: {}", against(&name));
            }
            for name in ["ink", "quiet"] {
                assert!(against(name) >= 4.5, "{name}: {}", against(name));
            }
        }
    }

    #[test]
    fn every_role_is_in_the_legend() {
        let page = page(&fixtures::report());
        for role in [Role::Method, Role::Paper, Role::Baseline] {
            assert!(page.contains(legend::role_name(role)));
        }
    }
}
