//! The key to a server: used in one place, shown in none.

use std::{fmt, sync::Arc};

use ureq::http::HeaderValue;

/// A text that must not be seen: it can be sent and struck out, but not printed, compared or written down.
#[derive(Clone)]
pub struct Secret(Arc<str>);

impl Secret {
    /// The secret in `text` without the blanks around it; `None` where nothing is left.
    pub fn new(text: &str) -> Option<Self> {
        let text = text.trim();
        (!text.is_empty()).then(|| Self(text.into()))
    }

    /// `Authorization: Bearer …`; `None` when no header can carry it.
    pub(super) fn bearer(&self) -> Option<HeaderValue> {
        let mut value = HeaderValue::from_str(&format!("Bearer {}", self.0)).ok()?;
        value.set_sensitive(true);
        Some(value)
    }

    /// `text` with every occurrence of the secret struck out: servers repeat what they refuse.
    pub fn struck_out(&self, text: &str) -> String {
        text.replace(&*self.0, "[key]")
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(…)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_shows_nowhere() {
        let secret = Secret::new(" canary-7f3a\n").unwrap();
        let header = secret.bearer().unwrap();
        assert_eq!(header.as_bytes(), b"Bearer canary-7f3a");
        for text in
            [format!("{secret:?} {header:?}"), secret.struck_out("wrong key canary-7f3a (canary-7f3a)")]
        {
            assert!(!text.contains("canary"), "{text}");
        }
        assert!(Secret::new(" \t").is_none());
        assert!(Secret::new("two\nlines").unwrap().bearer().is_none());
    }
}
