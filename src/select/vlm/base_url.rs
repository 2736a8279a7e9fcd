//! The address of a server.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};
use ureq::http::Uri;

/// The part of a server's address before `/chat/completions`, mostly `http://HOST:PORT/v1`. It holds no name, password
/// or query, so that it may be shown.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct BaseUrl(String);

/// Why an address was refused. It does not repeat the address, which may hold a password.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UrlError {
    /// No address at all.
    #[error("the model's address is not understood: expected http://HOST:PORT/v1 or https://HOST/v1")]
    Malformed,
    /// With more in it than an address.
    #[error(
        "the model's address holds a name, password, query or fragment: give the address alone, and the key in AGENTICFOCUS_VLM_KEY"
    )]
    Credentials,
}

impl BaseUrl {
    /// Where questions are posted.
    pub(super) fn endpoint(&self) -> String {
        format!("{}/chat/completions", self.0)
    }

    /// The host, with its port where one is given.
    pub fn host(&self) -> &str {
        let rest = self.0.split_once("://").map_or(self.0.as_str(), |(_, rest)| rest);
        rest.split('/').next().unwrap_or(rest)
    }

    /// Whether the server is this very machine.
    pub(super) fn is_local(&self) -> bool {
        let host = self.host();
        let name = if host.starts_with('[') {
            host.split_inclusive(']').next().unwrap_or(host)
        } else {
            host.split(':').next().unwrap_or(host)
        };
        let address = name.trim_matches(['[', ']']).parse::<std::net::IpAddr>();
        name == "localhost" || address.is_ok_and(|address| address.is_loopback())
    }

    /// Whether what is sent can be read on the way.
    pub(super) fn is_plain(&self) -> bool {
        self.0.starts_with("http://")
    }
}

impl FromStr for BaseUrl {
    type Err = UrlError;

    fn from_str(text: &str) -> Result<Self, UrlError> {
        let text = text.trim();
        // Before anything else: no later message may repeat a password.
        if text.contains(['@', '?', '#']) {
            return Err(UrlError::Credentials);
        }
        let trimmed = text.trim_end_matches('/');
        let base = trimmed.strip_suffix("/chat/completions").unwrap_or(trimmed);
        let uri: Uri = base.parse().map_err(|_| UrlError::Malformed)?;
        let has_scheme = matches!(uri.scheme_str(), Some("http" | "https"));
        let has_host = uri.host().is_some_and(|host| !host.is_empty());
        // The parser takes `HTTP://`; what follows compares plain text.
        let (scheme, rest) = base.split_once("://").ok_or(UrlError::Malformed)?;
        if has_scheme && has_host {
            Ok(Self(format!("{}://{}", scheme.to_lowercase(), rest.trim_end_matches('/'))))
        } else {
            Err(UrlError::Malformed)
        }
    }
}

impl TryFrom<String> for BaseUrl {
    type Error = UrlError;

    fn try_from(text: String) -> Result<Self, UrlError> {
        text.parse()
    }
}

impl From<BaseUrl> for String {
    fn from(url: BaseUrl) -> Self {
        url.0
    }
}

impl fmt::Display for BaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_taken_with_or_without_its_end() {
        for text in [
            "http://localhost:8000/v1",
            "http://localhost:8000/v1/",
            " HTTP://localhost:8000/v1/chat/completions",
        ] {
            let url: BaseUrl = text.parse().unwrap();
            assert_eq!(url.endpoint(), "http://localhost:8000/v1/chat/completions", "{text}");
            assert_eq!(url.host(), "localhost:8000");
            assert!(url.is_local() && url.is_plain());
        }
        assert!("http://[::1]:80/v1".parse::<BaseUrl>().unwrap().is_local());
        let far: BaseUrl = "https://models.example/v1".parse().unwrap();
        assert!(!far.is_local() && !far.is_plain());
    }

    #[test]
    fn what_is_no_address_is_refused_without_repeating_it() {
        for text in ["", "localhost:8000", "ftp://host/v1", "http://", "http:///v1", "/v1", "http://a b/"] {
            assert_eq!(text.parse::<BaseUrl>(), Err(UrlError::Malformed), "{text}");
        }
        let refused = "https://me:canary@host/v1".parse::<BaseUrl>().unwrap_err();
        assert_eq!(refused, UrlError::Credentials);
        assert!(!format!("{refused} {refused:?}").contains("canary"));
        assert!("http://h/v1?key=canary".parse::<BaseUrl>().is_err());
    }
}
