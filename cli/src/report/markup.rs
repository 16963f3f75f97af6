//! Markup written by hand: elements that always close, and text that is always escaped.

use std::fmt::{Display, Write};

/// HTML or SVG text in the making.
#[derive(Clone, Debug, Default)]
pub struct Markup {
    text: String,
}

/// Attributes of an element, escaped when they are written.
pub type Attributes<'a> = &'a [(&'a str, &'a dyn Display)];

impl Markup {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The text so far.
    pub fn into_string(self) -> String {
        self.text
    }

    /// An element with what `content` writes into it.
    pub fn element(
        &mut self,
        name: &str,
        attributes: Attributes<'_>,
        content: impl FnOnce(&mut Self),
    ) {
        self.start(name, attributes);
        self.text.push('>');
        content(self);
        self.push(format_args!("</{name}>"));
    }

    /// An element with text in it.
    pub fn inline(&mut self, name: &str, attributes: Attributes<'_>, text: impl Display) {
        self.element(name, attributes, |inside| inside.text(text));
    }

    /// An element with nothing in it.
    pub fn leaf(&mut self, name: &str, attributes: Attributes<'_>) {
        self.start(name, attributes);
        self.text.push_str("/>");
    }

    /// Text, escaped. Characters that no document may hold become the replacement character.
    pub fn text(&mut self, text: impl Display) {
        let mut escaped = Escaped(&mut self.text);
        write!(escaped, "{text}").expect("a string takes any text");
    }

    /// The end of a line of the source, which readers do not see.
    pub fn end_line(&mut self) {
        self.text.push('\n');
    }

    /// Text of our own that is markup already, such as a style sheet.
    pub fn trusted(&mut self, markup: &str) {
        self.text.push_str(markup);
    }

    fn start(&mut self, name: &str, attributes: Attributes<'_>) {
        self.push(format_args!("<{name}"));
        for (key, value) in attributes {
            self.push(format_args!(" {key}=\""));
            self.text(value);
            self.text.push('"');
        }
    }

    fn push(&mut self, arguments: std::fmt::Arguments<'_>) {
        self.text
            .write_fmt(arguments)
            .expect("a string takes any text");
    }
}

/// A sink that escapes.
struct Escaped<'a>(&'a mut String);

impl Write for Escaped<'_> {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        for character in text.chars() {
            match character {
                '&' => self.0.push_str("&amp;"),
                '<' => self.0.push_str("&lt;"),
                '>' => self.0.push_str("&gt;"),
                '"' => self.0.push_str("&quot;"),
                '\'' => self.0.push_str("&#39;"),
                '\t' | '\n' => self.0.push(character),
                _ if character.is_control() => self.0.push(char::REPLACEMENT_CHARACTER),
                // Non-characters, which XML forbids too.
                '\u{fffe}' | '\u{ffff}' => self.0.push(char::REPLACEMENT_CHARACTER),
                _ => self.0.push(character),
            }
        }
        Ok(())
    }
}

/// A coordinate in pixels, to a tenth.
#[derive(Clone, Copy, Debug)]
pub struct Px(pub f64);

impl Display for Px {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tenths = (self.0 * 10.0).round();
        if tenths % 10.0 == 0.0 {
            // Adding 0 turns the negative zero into the other.
            write!(formatter, "{}", tenths / 10.0 + 0.0)
        } else {
            write!(formatter, "{:.1}", tenths / 10.0)
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Asserts that every tag of `text` closes in its order, that attributes are quoted and `&` begins an entity.
    pub(crate) fn assert_well_formed(text: &str) {
        // Elements of HTML that have no end.
        const VOID: [&str; 3] = ["meta", "br", "link"];
        let mut open: Vec<&str> = Vec::new();
        let mut rest = text;
        while let Some(start) = rest.find('<') {
            assert_entities(&rest[..start]);
            rest = &rest[start..];
            let end = rest.find('>').expect("a tag that ends");
            let tag = &rest[1..end];
            rest = &rest[end + 1..];
            if tag.starts_with('!') {
                continue;
            }
            if let Some(name) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(name), "a closing tag before:\n{rest:.200}");
                continue;
            }
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            assert!(!tag.contains('<'), "{tag}");
            assert_entities(tag);
            let name = tag.split([' ', '/']).next().expect("a name");
            assert!(name.chars().all(|letter| letter.is_ascii_alphanumeric()));
            if name == "style" {
                let close = rest.find("</style>").expect("a style that ends");
                rest = &rest[close..];
            }
            if !tag.ends_with('/') && !VOID.contains(&name) {
                open.push(name);
            }
        }
        assert!(!rest.contains('>'));
        assert_eq!(open, Vec::<&str>::new());
    }

    fn assert_entities(text: &str) {
        for part in text.split('&').skip(1) {
            let end = part.find(';').unwrap_or_else(|| panic!("&{part}"));
            assert!(["amp", "lt", "gt", "quot", "#39"].contains(&&part[..end]));
        }
    }

    #[test]
    fn elements_close_and_text_is_escaped() {
        let mut markup = Markup::new();
        markup.element("p", &[("title", &"\"<&'")], |p| {
            p.leaf("br", &[]);
            p.text("a\u{1}</p><script>\n");
        });
        let text = markup.into_string();
        assert_well_formed(&text);
        assert_eq!(
            text,
            "<p title=\"&quot;&lt;&amp;&#39;\"><br/>a\u{fffd}&lt;/p&gt;&lt;script&gt;\n</p>"
        );
    }

    #[test]
    #[should_panic(expected = "a closing tag before")]
    fn the_checker_sees_tags_that_cross() {
        assert_well_formed("<p><b>a</p></b>");
    }

    #[test]
    fn coordinates_have_a_tenth_at_most() {
        let all = [1.0, 1.04, 1.06, -0.01, -2.56, 1234.5].map(|value| Px(value).to_string());
        assert_eq!(
            all,
            ["1", "1", "1.1", "0", "-2.6", "1234.5"].map(String::from)
        );
    }
}
