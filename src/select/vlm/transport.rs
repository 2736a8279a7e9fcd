//! Sending one question: time-outs, tries, waits.

use std::{
    io::Read as _,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    time::{Duration, Instant, SystemTime},
};

use serde_json::Value;
use ureq::{Agent, http::HeaderValue};

use super::{
    VlmServer,
    error::VlmError,
    reply::{self, Reply},
    request::{ResponseFormat, body},
    retry::{ATTEMPTS, LONGEST_WAIT, backoff, is_worth_another_try, retry_after},
};
use crate::progress::{Cancelled, Watch};

/// Most bytes of an answer: a thousand times what one needs.
const MOST_BYTES: u64 = 4 << 20;
/// How often somebody who waits looks whether they are still wanted.
const LOOK: Duration = Duration::from_millis(20);

/// A server, ready to be asked.
pub(super) struct Connection<'a> {
    server: &'a VlmServer,
    authorization: Option<HeaderValue>,
    /// Gets lines for the log.
    say: &'a dyn Fn(&str),
    /// How the answer's form is asked for, as far as the server was found to understand it.
    format: ResponseFormat,
}

/// What came back over the wire.
struct Raw {
    status: u16,
    retry_after: Option<String>,
    body: Vec<u8>,
}

/// Why nothing came back.
enum Lost {
    /// No connection, or it broke.
    Connection(String),
    /// Too late.
    Late,
    /// Too much.
    TooLarge,
    /// A fault that comes again.
    Other(String),
}

impl<'a> Connection<'a> {
    pub fn new(server: &'a VlmServer, say: &'a dyn Fn(&str)) -> Result<Self, VlmError> {
        let authorization = match &server.key {
            Some(key) => Some(key.bearer().ok_or(VlmError::Key)?),
            None => None,
        };
        if authorization.is_some() && server.url.is_plain() && !server.url.is_local() {
            say(&format!("the key goes to {} unencrypted: https would hide it", server.url.host()));
        }
        Ok(Self { server, authorization, say, format: ResponseFormat::first(server.profile) })
    }

    /// Sends `messages` until an answer comes or nothing more is to be hoped for.
    pub fn ask(&mut self, messages: &[Value], seed: &str, watch: &dyn Watch) -> Result<Reply, VlmError> {
        let host = || self.server.url.host().to_owned();
        let limit = self.server.total_timeout;
        let deadline = Instant::now() + limit;
        let mut attempt = 1;
        loop {
            let bytes = body(&self.server.model, messages, self.format)?;
            let left = deadline.saturating_duration_since(Instant::now());
            let asked_for = match self.post(bytes, left, watch)? {
                Ok(raw) if raw.status == 200 => {
                    let read = reply::read(&raw.body);
                    return read.map_err(|reason| VlmError::Protocol { host: host(), reason });
                }
                Ok(raw) if self.asks_less(&raw) => continue,
                Ok(raw) if !is_worth_another_try(raw.status) || attempt == ATTEMPTS => {
                    let said = reply::excerpt(&raw.body);
                    return Err(VlmError::Refused { host: host(), status: raw.status, said });
                }
                Ok(raw) => {
                    let wait = raw.retry_after.and_then(|text| retry_after(&text, SystemTime::now()));
                    let left = deadline.saturating_duration_since(Instant::now());
                    if let Some(wait) = wait.filter(|wait| *wait > LONGEST_WAIT.min(left)) {
                        return Err(VlmError::Busy { host: host(), status: raw.status, wait });
                    }
                    (self.say)(&format!("{} is busy ({}), it is asked again", host(), raw.status));
                    wait
                }
                Err(Lost::Late) => return Err(VlmError::Timeout { host: host(), limit }),
                Err(Lost::TooLarge) => return Err(VlmError::TooLarge { host: host(), limit: MOST_BYTES }),
                Err(Lost::Other(reason)) => return Err(VlmError::Protocol { host: host(), reason }),
                Err(Lost::Connection(reason)) if attempt == ATTEMPTS => {
                    return Err(VlmError::Connect { host: host(), reason });
                }
                Err(Lost::Connection(_)) => None,
            };
            let wait = asked_for.unwrap_or_else(|| backoff(self.server.first_wait, attempt, seed));
            if Instant::now() + wait >= deadline {
                return Err(VlmError::Timeout { host: host(), limit });
            }
            sleep(wait, watch)?;
            attempt += 1;
        }
    }

    /// Whether `raw` refuses the form of the answer and a simpler one is left to ask for.
    fn asks_less(&mut self, raw: &Raw) -> bool {
        if !matches!(raw.status, 400 | 422) || !reply::is_about_format(&raw.body) {
            return false;
        }
        let Some(next) = self.format.next() else { return false };
        let (host, now) = (self.server.url.host(), self.format.name());
        (self.say)(&format!("{host} does not take {now}, {} is asked for", next.name()));
        self.format = next;
        true
    }

    /// An answer without the key, should the server repeat it: whatever is made of the answer cannot hold it.
    fn without_key(&self, mut raw: Raw) -> Raw {
        if let Some(key) = &self.server.key {
            raw.body = key.struck_out(&String::from_utf8_lossy(&raw.body)).into_bytes();
        }
        raw
    }

    /// Posts on a thread of its own, so that whoever waits can be told to stop.
    fn post(&self, bytes: Vec<u8>, left: Duration, watch: &dyn Watch) -> Result<Result<Raw, Lost>, VlmError> {
        let agent = agent(self.server, left);
        let (endpoint, authorization) = (self.server.url.endpoint(), self.authorization.clone());
        let (sender, receiver) = mpsc::channel();
        let unwanted = Arc::new(AtomicBool::new(false));
        let is_unwanted = Arc::clone(&unwanted);
        std::thread::Builder::new()
            .name("vlm".to_owned())
            .spawn(move || {
                let result = exchange(&agent, &endpoint, authorization, &bytes, &is_unwanted);
                // Nobody may wait any more.
                sender.send(result).ok();
            })
            .map_err(VlmError::Thread)?;
        // The client keeps its own time; this only holds should it not.
        let end = Instant::now() + left + Duration::from_secs(1);
        loop {
            match receiver.recv_timeout(LOOK) {
                Ok(result) => return Ok(result.map(|raw| self.without_key(raw))),
                Err(mpsc::RecvTimeoutError::Timeout) if Instant::now() > end => {
                    unwanted.store(true, Ordering::Relaxed);
                    return Ok(Err(Lost::Late));
                }
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => {
                    return Ok(Err(Lost::Other("the request ended without a word".to_owned())));
                }
            }
            if watch.is_cancelled() {
                unwanted.store(true, Ordering::Relaxed);
                return Err(Cancelled.into());
            }
        }
    }
}

fn agent(server: &VlmServer, left: Duration) -> Agent {
    let connect = server.connect_timeout.min(left);
    let config = Agent::config_builder()
        .timeout_global(Some(left))
        .timeout_resolve(Some(connect))
        .timeout_connect(Some(connect))
        .http_status_as_error(false)
        // Pictures and key go where they were sent, and nowhere else.
        .max_redirects(0)
        .user_agent(concat!("agenticfocus/", env!("CARGO_PKG_VERSION")));
    // A proxy reaches other machines; this one needs none.
    let config = if server.url.is_local() { config.proxy(None) } else { config };
    config.build().new_agent()
}

/// One request and the whole of its answer.
fn exchange(
    agent: &Agent,
    endpoint: &str,
    authorization: Option<HeaderValue>,
    bytes: &[u8],
    unwanted: &AtomicBool,
) -> Result<Raw, Lost> {
    let mut request = agent.post(endpoint).content_type("application/json");
    if let Some(value) = authorization {
        request = request.header("Authorization", value);
    }
    let response = request.send(bytes).map_err(lost)?;
    let status = response.status().as_u16();
    let retry_after = response.headers().get("retry-after").and_then(|value| value.to_str().ok());
    let retry_after = retry_after.map(str::to_owned);
    if response.body().content_length().is_some_and(|length| length > MOST_BYTES) {
        return Err(Lost::TooLarge);
    }
    let mut body = Vec::new();
    let mut reader = response.into_body().into_reader();
    let mut piece = vec![0; 64 << 10];
    loop {
        let count = reader.read(&mut piece).map_err(|error| lost(ureq::Error::from(error)))?;
        if count == 0 {
            return Ok(Raw { status, retry_after, body });
        }
        body.extend_from_slice(&piece[..count]);
        if body.len() as u64 > MOST_BYTES {
            return Err(Lost::TooLarge);
        }
        if unwanted.load(Ordering::Relaxed) {
            return Err(Lost::Other("it is no longer wanted".to_owned()));
        }
    }
}

/// What an error of the client means. Only texts that cannot hold anything of ours are passed on.
fn lost(error: ureq::Error) -> Lost {
    use ureq::{Error, Timeout};
    match error {
        Error::Timeout(Timeout::Connect | Timeout::Resolve) => {
            Lost::Connection("no connection in time".to_owned())
        }
        Error::Timeout(_) => Lost::Late,
        Error::Io(error) => Lost::Connection(error.kind().to_string()),
        Error::HostNotFound => Lost::Connection("no such host".to_owned()),
        Error::ConnectionFailed => Lost::Connection("connection refused".to_owned()),
        Error::Rustls(error) => Lost::Other(format!("TLS: {error}")),
        Error::Tls(reason) => Lost::Other(format!("TLS: {reason}")),
        Error::Protocol(_) => Lost::Other("no HTTP".to_owned()),
        Error::LargeResponseHeader(..) => Lost::TooLarge,
        Error::Decompress(..) => Lost::Other("damaged compression".to_owned()),
        _ => Lost::Other("the request failed".to_owned()),
    }
}

fn sleep(wait: Duration, watch: &dyn Watch) -> Result<(), Cancelled> {
    let end = Instant::now() + wait;
    loop {
        watch.check()?;
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Ok(());
        }
        std::thread::sleep(left.min(LOOK));
    }
}
