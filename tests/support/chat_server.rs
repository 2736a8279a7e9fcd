//! A server in this process that speaks the chat protocol, well or badly, as a test tells it.
#![allow(dead_code, clippy::unwrap_used, reason = "each test uses its part; a failing unwrap fails the test")]

use std::{
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{TcpListener, TcpStream},
    sync::{Arc, Mutex},
    thread,
    time::Duration,
};

use serde_json::{Value, json};

/// What the server does with a request.
#[derive(Clone, Debug)]
pub enum Act {
    /// Answers with a status, more header lines and a body.
    Answer(u16, Vec<String>, Vec<u8>),
    /// Never answers.
    Silence,
    /// Answers with this many bytes; whether it says so beforehand.
    Flood { bytes: u64, announced: bool },
    /// Closes the connection without a word.
    HangUp,
}

impl Act {
    /// A model that wrote `content`.
    pub fn says(content: &str) -> Self {
        Self::chat(json!({"message": {"role": "assistant", "content": content}, "finish_reason": "stop"}))
    }

    /// An answer with this choice.
    pub fn chat(choice: Value) -> Self {
        Self::Answer(200, Vec::new(), json!({"choices": [choice]}).to_string().into_bytes())
    }

    /// A refusal.
    pub fn refuses(status: u16, message: &str) -> Self {
        Self::Answer(status, Vec::new(), json!({"error": {"message": message}}).to_string().into_bytes())
    }

    /// The same with one more header line.
    pub fn with(self, header: &str) -> Self {
        match self {
            Self::Answer(status, mut headers, body) => {
                headers.push(header.to_owned());
                Self::Answer(status, headers, body)
            }
            other => other,
        }
    }
}

/// A request as it came.
#[derive(Clone, Debug)]
pub struct Asked {
    /// First line and headers, as sent.
    pub head: String,
    /// The body.
    pub body: Value,
}

/// A running server.
pub struct ChatServer {
    /// Its address up to `/v1`.
    pub url: String,
    asked: Arc<Mutex<Vec<Asked>>>,
}

impl ChatServer {
    /// Starts one that does what `act` says, which gets the request's number, from 0, and the request.
    pub fn start(act: impl Fn(usize, &Asked) -> Act + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}/v1", listener.local_addr().unwrap());
        let asked: Arc<Mutex<Vec<Asked>>> = Arc::default();
        let (log, act) = (Arc::clone(&asked), Arc::new(act));
        thread::spawn(move || {
            for stream in listener.incoming().map_while(Result::ok) {
                let (log, act) = (Arc::clone(&log), Arc::clone(&act));
                thread::spawn(move || serve(stream, &log, &*act));
            }
        });
        Self { url, asked }
    }

    /// One that acts in turn; the last act is repeated.
    pub fn acting(acts: &[Act]) -> Self {
        let acts = acts.to_vec();
        Self::start(move |number, _| acts[number.min(acts.len() - 1)].clone())
    }

    /// What it was asked so far.
    pub fn asked(&self) -> Vec<Asked> {
        self.asked.lock().unwrap().clone()
    }
}

fn serve(stream: TcpStream, log: &Mutex<Vec<Asked>>, act: &dyn Fn(usize, &Asked) -> Act) {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let (mut head, mut length) = (String::new(), 0);
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line).unwrap_or(0) == 0 {
            return;
        }
        if let Some(value) = line.to_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        if line == "\r\n" {
            break;
        }
        head += &line;
    }
    let mut body = vec![0; length];
    if reader.read_exact(&mut body).is_err() {
        return;
    }
    let asked = Asked { head, body: serde_json::from_slice(&body).unwrap_or_default() };
    let number = {
        let mut log = log.lock().unwrap();
        log.push(asked.clone());
        log.len() - 1
    };
    let mut stream = stream;
    match act(number, &asked) {
        Act::Answer(status, headers, body) => {
            let mut head =
                format!("HTTP/1.1 {status} So\r\nContent-Length: {}\r\nConnection: close\r\n", body.len());
            head.extend(headers.iter().map(|header| format!("{header}\r\n")));
            stream.write_all(format!("{head}\r\n").as_bytes()).ok();
            stream.write_all(&body).ok();
        }
        Act::Silence => thread::sleep(Duration::from_secs(30)),
        Act::Flood { bytes, announced } => {
            let length = if announced { format!("Content-Length: {bytes}\r\n") } else { String::new() };
            let head = format!("HTTP/1.1 200 OK\r\n{length}Connection: close\r\n\r\n");
            stream.write_all(head.as_bytes()).ok();
            let piece = vec![b'a'; 1 << 20];
            for _ in 0..bytes >> 20 {
                if stream.write_all(&piece).is_err() {
                    return;
                }
            }
        }
        Act::HangUp => {}
    }
}
