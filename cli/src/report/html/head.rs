//! The head of the page: what was measured with, what to beware of, and how to read it all.

use super::super::document::Report;
use super::super::markup::Markup;
use super::super::panel::{Panel, panels};
use super::super::units;
use super::anchor;

/// Draws the title, warnings, the machine, the list of contents and how to read the plots.
pub fn draw(header: &mut Markup, report: &Report) {
    header.inline("h1", &[], "Error against run time");
    header.inline(
        "p",
        &[("class", &"lead-in")],
        "How close glinty normal distributions come to the truth of every texel, and what that costs in time and memory.",
    );
    if !report.complete {
        header.inline(
            "p",
            &[("class", &"warning"), ("role", &"note")],
            "This report is not complete: its run is going on or was interrupted. Rows that were planned are missing; \
             those that are here are whole.",
        );
    }
    if !report.head.optimised {
        header.inline(
            "p",
            &[("class", &"warning"), ("role", &"note")],
            "The program was compiled without optimisation. Errors and bytes hold, times mean little.",
        );
    }
    draw_machine(header, report);
    draw_contents(header, report);
    header.element("details", &[("open", &"open")], |details| {
        details.inline("summary", &[], "How to read this");
        details.element("div", &[("class", &"inside")], |inside| {
            for text in READING {
                inside.inline("p", &[], text);
            }
            inside.element("p", &[], |p| {
                p.text("What the norms are is ");
                p.inline("a", &[("href", &"#norms")], "at the end");
                p.text(".");
            });
        });
    });
}

fn draw_machine(header: &mut Markup, report: &Report) {
    let head = &report.head;
    let facts: [(&str, &str, &str); 9] = [
        ("Command", "wide", &head.command),
        ("Processor", "", &head.processor),
        ("Target", "", &head.target),
        (
            "Instruction sets beyond its least",
            "",
            &head.target_features,
        ),
        ("Compiler", "", &head.compiler),
        ("glintbake", "", &head.glintbake),
        ("Seed", "", &head.seed.to_string()),
        (
            "Threads of bakes; queries have one",
            "",
            &head.threads.to_string(),
        ),
        (
            "Clock resolution",
            "",
            &units::time(head.clock_resolution_ns),
        ),
    ];
    header.element("dl", &[("class", &"machine")], |list| {
        for (name, class, value) in facts {
            list.element("div", &[("class", &class)], |pair| {
                pair.inline("dt", &[], name);
                pair.element("dd", &[], |value_of| {
                    let value = if value.is_empty() { "none" } else { value };
                    if class.is_empty() {
                        value_of.text(value);
                    } else {
                        value_of.inline("code", &[], value);
                    }
                });
            });
        }
    });
}

fn draw_contents(header: &mut Markup, report: &Report) {
    header.element("nav", &[("aria-label", &"Maps")], |nav| {
        nav.element("ul", &[], |list| {
            for (number, map) in report.maps.iter().enumerate() {
                list.element("li", &[], |item| {
                    let target = format!("#{}", anchor(number, None));
                    item.element("strong", &[], |strong| {
                        strong.inline("a", &[("href", &target)], &map.name);
                    });
                    let titles: Vec<String> = panels(map).iter().map(Panel::title).collect();
                    if titles.is_empty() {
                        return;
                    }
                    item.element("ul", &[], |inner| {
                        for (place, title) in titles.iter().enumerate() {
                            let target = format!("#{}", anchor(number, Some(place)));
                            inner.element("li", &[], |item| {
                                item.inline("a", &[("href", &target)], title);
                            });
                        }
                    });
                });
            }
        });
    });
}

const READING: [&str; 4] = [
    "Each contestant is asked for the density D of half vectors under footprints of several sizes, and its answers are \
     held against the truth: every texel under the footprint with its own normal, summed in double precision by code \
     that shares nothing with what is measured. Kernels, filters and roughnesses have panels of their own; only what is \
     within one panel compares.",
    "Error against time: down and left is better, both axes are logarithmic. The stairs are the Pareto front: nothing \
     else is both faster and closer than the named marks on it, and everything in the tint beyond is beaten. The area of \
     a mark is the memory, in bytes a texel. Errors below 0.001 %, zero included, are in the strip at the foot, and are \
     equal to each other.",
    "The size σ is half the edge of a square footprint in texels; of an elongated one, half the geometric mean of both \
     edges. Footprints are turned by random angles and lie at random places. Half vectors are drawn from the truth, so \
     that they are those that light meets; the table of all rows has uniform ones too.",
    "Times are medians over repetitions on one thread, in random order of queries unless a plot says coherent; bars reach \
     from the first quartile to the third. Colours and shapes stay with their contestants on the whole page, and marks \
     tell their numbers when the pointer rests on them.",
];

const NORMS: [(&str, &str); 8] = [
    (
        "Relative L1",
        "Σ |D − D*| / Σ D*, over all queries of a row; D is the answer, D* the truth. The error of every plot.",
    ),
    (
        "RMS",
        "Root of the mean square of D − D*, as a share of the mean of D*: large where single answers are far off.",
    ),
    (
        "99th percentile",
        "What one answer in a hundred exceeds: a percentile of |D − D*|, as a share of the largest D*.",
    ),
    (
        "Worst",
        "The largest |D − D*|, as a share of the largest D*.",
    ),
    (
        "Unlit",
        "The largest answer where the truth is zero, per steradian.",
    ),
    (
        "Model error",
        "The relative L1 error against the method's own definition, evaluated in double precision: what \
      arithmetic and storage add to the method. Baselines have none.",
    ),
    (
        "Energy",
        "What the sampler keeps: the integral of the contestant's pdf as a share of the truth's, ± one standard error.",
    ),
    (
        "Sampling as long",
        "The relative L1 error of point sampling when it may take as long as the contestant's eval; \
      above the contestant's own error, the contestant is worth its time.",
    ),
];

/// Draws the definitions of the norms.
pub fn draw_definitions(main: &mut Markup) {
    main.element("section", &[("id", &"norms")], |section| {
        section.inline("h2", &[], "Norms");
        section.element("dl", &[("class", &"norms")], |list| {
            for (name, text) in NORMS {
                list.inline("dt", &[], name);
                list.inline("dd", &[], text);
            }
        });
    });
}
