//! Access control: requests must come from this machine's page and have the token.

use hyper::HeaderMap;
use hyper::header::{AUTHORIZATION, HOST, HeaderName, ORIGIN};

/// Whether a request comes from the page that this server sent: its host is this machine by name or number, with any
/// port (it may be forwarded), and its origin, if it has one, is that host. A page of another site that a browser
/// reached here by a name of its own has another host, and one that sends requests from there another origin.
pub(crate) fn is_local(headers: &HeaderMap) -> bool {
    let Some(host) = text(headers, &HOST) else { return false };
    let name = host
        .rsplit_once(':')
        .map_or(host, |(name, port)| if port.bytes().all(|byte| byte.is_ascii_digit()) { name } else { host });
    let is_loopback = ["127.0.0.1", "localhost", "[::1]"].contains(&name);
    let origin = headers.get(ORIGIN).map(|_| text(headers, &ORIGIN).and_then(|origin| origin.strip_prefix("http://")));
    is_loopback && origin.is_none_or(|origin| origin == Some(host))
}

/// Whether a request has the token, in a time that does not depend on where it differs.
pub(crate) fn has_token(headers: &HeaderMap, token: &str) -> bool {
    let given = text(headers, &AUTHORIZATION).and_then(|value| value.strip_prefix("Bearer ")).unwrap_or_default();
    let differs = given.bytes().zip(token.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
    given.len() == token.len() && differs == 0
}

/// The text of a header that occurs once.
fn text<'h>(headers: &'h HeaderMap, name: &HeaderName) -> Option<&'h str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(pairs: &[(HeaderName, &str)]) -> HeaderMap {
        pairs.iter().map(|(name, value)| (name.clone(), value.parse().unwrap())).collect()
    }

    #[test]
    fn other_hosts_and_origins_are_refused() {
        for (host, origin, expected) in [
            ("127.0.0.1:8700", None, true),
            ("localhost:9", None, true),
            ("[::1]:8700", None, true),
            ("localhost", Some("http://localhost"), true),
            ("127.0.0.1:8700", Some("http://127.0.0.1:8700"), true),
            ("127.0.0.1:8700", Some("http://127.0.0.1:8701"), false),
            ("127.0.0.1:8700", Some("null"), false),
            ("127.0.0.1:8700", Some("https://evil.example"), false),
            ("evil.example:8700", None, false),
            ("evil.example", Some("http://evil.example"), false),
            ("127.0.0.1.evil.example", None, false),
            ("", None, false),
        ] {
            let mut pairs = vec![(HOST, host)];
            pairs.extend(origin.map(|origin| (ORIGIN, origin)));
            assert_eq!(is_local(&headers(&pairs)), expected, "{host} {origin:?}");
        }
        assert!(!is_local(&HeaderMap::new()));
        let mut two = headers(&[(HOST, "localhost")]);
        two.append(HOST, "evil.example".parse().unwrap());
        assert!(!is_local(&two));
    }

    #[test]
    fn the_token_is_needed_whole() {
        for (given, expected) in
            [("Bearer abc", true), ("Bearer ab", false), ("Bearer abd", false), ("abc", false), ("Bearer abcd", false)]
        {
            assert_eq!(has_token(&headers(&[(AUTHORIZATION, given)]), "abc"), expected, "{given}");
        }
        assert!(!has_token(&HeaderMap::new(), "abc"));
    }
}
