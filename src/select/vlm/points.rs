//! Points in the markup of models that point: `<point x="61.5" y="40.6" alt="cup">cup</point>`, `Click(61.5, 40.6)`.

use crate::geometry::Pixel;

/// The first point in `text`, percent of the picture; `None` where there is none or it lies outside of 0 to 100.
pub(super) fn first(text: &str) -> Option<Pixel> {
    in_markup(text).or_else(|| in_click(text)).filter(|point| {
        let inside = 0.0..=100.0;
        inside.contains(&point.x) && inside.contains(&point.y)
    })
}

/// What the point is called.
pub(super) fn label(text: &str) -> Option<String> {
    let tag = tag(text)?;
    let value = tag.split_once("alt=")?.1;
    let quote = value.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    value[1..].split(quote).next().map(str::to_owned).filter(|label| !label.trim().is_empty())
}

/// The inside of the first `<point …>` or `<points …>`.
fn tag(text: &str) -> Option<&str> {
    let (_, rest) = text.split_once("<point")?;
    rest.split('>').next()
}

fn in_markup(text: &str) -> Option<Pixel> {
    let tag = tag(text)?;
    let value = |names: [&str; 2]| {
        let (_, rest) = names.iter().find_map(|name| tag.split_once(name))?;
        leading_number(rest.trim_start_matches(['"', '\'', ' ']))
    };
    Some(Pixel::new(value([" x=", " x1="])?, value([" y=", " y1="])?))
}

fn in_click(text: &str) -> Option<Pixel> {
    let (_, rest) = text.split_once("Click(")?;
    let (x, rest) = rest.split_once(',')?;
    Some(Pixel::new(x.trim().parse().ok()?, leading_number(rest.trim_start())?))
}

fn leading_number(text: &str) -> Option<f64> {
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).unwrap_or(text.len());
    text[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_in_each_markup_and_only_within_the_picture() {
        let one = r#"<point x="61.5" y="40.6" alt="the cup">the cup</point>"#;
        assert_eq!(first(one), Some(Pixel::new(61.5, 40.6)));
        assert_eq!(label(one).as_deref(), Some("the cup"));
        let many = r#"<points x1="10" y1="20" x2="30" y2="40" alt="knives">"#;
        assert_eq!(first(many), Some(Pixel::new(10.0, 20.0)));
        assert_eq!(first("Click(3.5, 99)"), Some(Pixel::new(3.5, 99.0)));
        assert_eq!(first(r#"<point x="612" y="40">"#), None);
        for broken in
            ["<point", "<point x=", r#"<point x="a" y="2">"#, "Click(", "Click(1", "", "<point alt=é"]
        {
            assert_eq!((first(broken), label(broken)), (None, None), "{broken}");
        }
    }
}
