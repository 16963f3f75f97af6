//! Who is which mark.

use super::super::document::Role;
use super::super::markup::{Markup, Px};
use super::super::panel::Panel;
use super::super::plot::marks::{Look, Looks, Shape};
use super::plots::radius;

/// What the shape of marks tells.
pub fn role_name(role: Role) -> &'static str {
    match role {
        Role::Method => "method",
        Role::Paper => "as a paper prints it",
        Role::Baseline => "baseline",
    }
}

/// Draws the contestants of `panel` with their marks, then what shapes and areas mean.
pub fn draw(section: &mut Markup, panel: &Panel<'_>, looks: &Looks<'_>) {
    section.element(
        "ul",
        &[("class", &"legend"), ("aria-label", &"Legend")],
        |list| {
            for contestant in &panel.contestants {
                list.element("li", &[], |item| {
                    draw_key(item, looks.of(contestant));
                    item.text(contestant.name());
                });
            }
        },
    );
    section.element("ul", &[("class", &"legend")], |list| {
        for role in [Role::Method, Role::Paper, Role::Baseline] {
            if panel
                .contestants
                .iter()
                .any(|contestant| contestant.role == role)
            {
                note(list, role_name(role), |svg| {
                    Shape::of(role).draw(svg, [15.0, 8.0], 4.5, "");
                });
            }
        }
        for bytes in [4.0, 16.0] {
            note(list, &format!("{bytes} bytes a texel"), |svg| {
                Shape::Circle.draw(svg, [15.0, 8.0], radius(Some(bytes)), "");
            });
        }
    });
    section.end_line();
}

fn note(list: &mut Markup, text: &str, mark: impl FnOnce(&mut Markup)) {
    list.element("li", &[("class", &"note")], |item| {
        item.element(
            "svg",
            &[
                ("class", &"key mark"),
                ("viewBox", &"0 0 30 16"),
                ("aria-hidden", &"true"),
            ],
            mark,
        );
        item.text(text);
    });
}

/// Draws line and mark of `look`, as wide as two letters.
pub fn draw_key(markup: &mut Markup, look: &Look) {
    markup.element(
        "svg",
        &[
            ("class", &"key"),
            ("viewBox", &"0 0 30 16"),
            ("style", &look.style()),
            ("aria-hidden", &"true"),
        ],
        |svg| {
            let class = if look.is_dashed {
                "line dashed"
            } else {
                "line"
            };
            let line = format!("M1 {y}H29", y = Px(8.0));
            svg.leaf("path", &[("class", &class), ("d", &line)]);
            let class = if look.is_dashed {
                "mark hollow"
            } else {
                "mark"
            };
            svg.element("g", &[("class", &class)], |group| {
                look.shape.draw(group, [15.0, 8.0], 4.6, "")
            });
        },
    );
}
