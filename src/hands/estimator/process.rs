//! Starting, feeding and ending the estimator process.

use std::{
    io::{BufRead, BufReader, Read, Write},
    path::PathBuf,
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel},
    time::Duration,
};

use serde::{Deserialize, Serialize};

use super::{
    protocol::{Answer, Header, Hello, Mode, PROTOCOL, Welcome},
    stderr_tail::StderrTail,
};
use crate::{
    clip::FrameIndex,
    hands::{HandsError, detection::Detection},
    image::Rgb8,
    select::vlm::KEY_VARIABLE,
};

/// How to run a hand estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatorCommand {
    /// The program, for example the Python of a virtual environment.
    pub program: PathBuf,
    /// Its arguments, for example the script.
    pub args: Vec<String>,
    /// Longest wait for the handshake, seconds (default 120: imports and models load slowly).
    pub start_timeout_s: f64,
    /// Longest wait for one picture's answer, seconds (default 60).
    pub frame_timeout_s: f64,
}

impl EstimatorCommand {
    /// `program args…` with the default time-outs.
    pub fn new(program: impl Into<PathBuf>, args: impl IntoIterator<Item = String>) -> Self {
        Self {
            program: program.into(),
            args: args.into_iter().collect(),
            start_timeout_s: 120.0,
            frame_timeout_s: 60.0,
        }
    }
}

/// A picture for the estimator.
#[derive(Debug)]
pub(in crate::hands) struct Request {
    pub frame: FrameIndex,
    pub mode: Mode,
    pub picture: Rgb8,
}

/// Pictures in flight: enough to hide the host's own work, few enough to bound memory.
const PICTURES_AHEAD: usize = 2;
/// An answer with twenty hands is 30 kB; a line beyond this is no answer.
const LONGEST_LINE: u64 = 1 << 20;

/// A running estimator. Dropping it ends the process.
#[derive(Debug)]
pub(in crate::hands) struct EstimatorProcess {
    program: PathBuf,
    child: Child,
    stderr: StderrTail,
    requests: Option<SyncSender<(u64, Request)>>,
    lines: Receiver<std::io::Result<String>>,
    frame_timeout: Duration,
    sent: u64,
    received: u64,
    name: String,
}

impl EstimatorProcess {
    /// Starts the estimator for a clip of `frames` frames and shakes hands.
    pub fn start(command: &EstimatorCommand, frames: usize) -> Result<Self, HandsError> {
        let program = command.program.clone();
        let start = |source| HandsError::Start { program: program.clone(), source };
        let missing = || std::io::Error::other("no pipe");
        let mut child = Command::new(&command.program)
            .args(&command.args)
            // It may be anybody's script, and what it writes is quoted.
            .env_remove(KEY_VARIABLE)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(start)?;
        let stderr = StderrTail::watch(child.stderr.take().ok_or_else(missing).map_err(start)?);
        let stdout = child.stdout.take().ok_or_else(missing).map_err(start)?;
        let stdin = child.stdin.take().ok_or_else(missing).map_err(start)?;
        let (line_sender, lines) = sync_channel(PICTURES_AHEAD + 2);
        std::thread::spawn(move || read_lines(stdout, &line_sender));
        let (requests, request_receiver) = sync_channel(PICTURES_AHEAD);
        std::thread::spawn(move || write_requests(stdin, frames, &request_receiver));
        let mut process = Self {
            program,
            child,
            stderr,
            requests: Some(requests),
            lines,
            frame_timeout: seconds(command.frame_timeout_s),
            sent: 0,
            received: 0,
            name: String::new(),
        };
        process.shake_hands(seconds(command.start_timeout_s))?;
        Ok(process)
    }

    fn shake_hands(&mut self, timeout: Duration) -> Result<(), HandsError> {
        let line = self.next_line(timeout, "waiting for its handshake")?;
        let refuse = |found: &str| HandsError::Protocol {
            program: self.program.clone(),
            found: found.chars().take(200).collect(),
            expected: PROTOCOL,
        };
        let hello: Hello = serde_json::from_str(&line).map_err(|_| refuse(&line))?;
        if hello.protocol != PROTOCOL {
            return Err(refuse(&hello.protocol));
        }
        self.name = if hello.name.is_empty() { "external".to_owned() } else { hello.name };
        Ok(())
    }

    /// What the estimator calls itself.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Requests without an answer yet.
    pub fn in_flight(&self) -> u64 {
        self.sent - self.received
    }

    /// Whether another request can be sent before an answer is taken.
    pub fn has_room(&self) -> bool {
        self.in_flight() < PICTURES_AHEAD as u64
    }

    /// Sends a picture. Call only while [`Self::has_room`].
    pub fn send(&mut self, request: Request) -> Result<(), HandsError> {
        let delivered = match &self.requests {
            Some(requests) => requests.send((self.sent, request)).is_ok(),
            None => false,
        };
        if !delivered {
            return Err(self.ended("sending a picture"));
        }
        self.sent += 1;
        Ok(())
    }

    /// The answer to the oldest request that has none yet, keypoints in pixels of the picture sent.
    pub fn receive(&mut self) -> Result<Vec<Detection>, HandsError> {
        let doing = format!("answering request {}", self.received);
        let line = self.next_line(self.frame_timeout, &doing)?;
        let parsed = serde_json::from_str::<Answer>(&line).map_err(|error| error.to_string());
        let detections = parsed.and_then(|answer| answer.into_detections(self.received));
        let detections = detections.map_err(|reason| HandsError::Answer {
            program: self.program.clone(),
            doing,
            reason,
        })?;
        self.received += 1;
        Ok(detections)
    }

    /// Sends one picture and waits for its answer.
    pub fn ask(&mut self, request: Request) -> Result<Vec<Detection>, HandsError> {
        self.send(request)?;
        self.receive()
    }

    fn next_line(&mut self, timeout: Duration, doing: &str) -> Result<String, HandsError> {
        match self.lines.recv_timeout(timeout) {
            Ok(Ok(line)) => Ok(line),
            Ok(Err(error)) => Err(HandsError::Answer {
                program: self.program.clone(),
                doing: doing.to_owned(),
                reason: error.to_string(),
            }),
            Err(RecvTimeoutError::Disconnected) => Err(self.ended(doing)),
            Err(RecvTimeoutError::Timeout) => {
                self.kill();
                Err(HandsError::TimedOut {
                    program: self.program.clone(),
                    seconds: timeout.as_secs_f64(),
                    doing: doing.to_owned(),
                    stderr: self.stderr.quote(),
                })
            }
        }
    }

    fn ended(&mut self, doing: &str) -> HandsError {
        self.requests = None;
        // Output is closed, so the process is ending; if it lingers it is ended.
        let status = self.wait_briefly();
        HandsError::Ended {
            program: self.program.clone(),
            status,
            doing: doing.to_owned(),
            stderr: self.stderr.quote(),
        }
    }

    fn wait_briefly(&mut self) -> String {
        for _ in 0..100 {
            match self.child.try_wait() {
                Ok(Some(status)) => {
                    // Its last words may still be on their way through the pipe.
                    std::thread::sleep(Duration::from_millis(50));
                    return status.to_string();
                }
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                Err(error) => return error.to_string(),
            }
        }
        self.kill();
        "closed its output without exiting".to_owned()
    }

    fn kill(&mut self) {
        // Failing to end a process that is already gone is no failure.
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

impl Drop for EstimatorProcess {
    fn drop(&mut self) {
        self.requests = None;
        self.kill();
    }
}

fn seconds(value: f64) -> Duration {
    Duration::try_from_secs_f64(value).unwrap_or(Duration::MAX).min(Duration::from_secs(86_400))
}

fn read_lines(stdout: ChildStdout, sender: &SyncSender<std::io::Result<String>>) {
    let mut stdout = BufReader::new(stdout);
    loop {
        let mut line = String::new();
        let result = match stdout.by_ref().take(LONGEST_LINE).read_line(&mut line) {
            Ok(0) => return,
            Ok(_) if !line.ends_with('\n') && line.len() as u64 >= LONGEST_LINE => {
                Err(std::io::Error::other(format!("a line longer than {LONGEST_LINE} bytes")))
            }
            Ok(_) => Ok(line),
            Err(error) => Err(error),
        };
        let failed = result.is_err();
        if sender.send(result).is_err() || failed {
            return;
        }
    }
}

fn write_requests(stdin: ChildStdin, frames: usize, requests: &Receiver<(u64, Request)>) {
    // A process that stops reading shows itself on its output: the reader reports it.
    let mut stdin = std::io::BufWriter::with_capacity(1 << 16, stdin);
    if write_line(&mut stdin, &Welcome { protocol: PROTOCOL, frames }).is_err() {
        return;
    }
    while let Ok((id, request)) = requests.recv() {
        let size = request.picture.size();
        let Request { frame, mode, picture } = request;
        let header = Header { id, frame: frame.0, mode, width: size.width, height: size.height };
        let written = write_line(&mut stdin, &header)
            .and_then(|()| stdin.write_all(picture.data()))
            .and_then(|()| stdin.flush());
        if written.is_err() {
            return;
        }
    }
}

fn write_line(stream: &mut impl Write, message: &impl Serialize) -> std::io::Result<()> {
    let mut line = serde_json::to_vec(message)?;
    line.push(b'\n');
    stream.write_all(&line)?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Size;

    fn shell(script: &str) -> EstimatorCommand {
        let mut command = EstimatorCommand::new("/bin/sh", ["-c".to_owned(), script.to_owned()]);
        (command.start_timeout_s, command.frame_timeout_s) = (5.0, 0.5);
        command
    }

    fn request() -> Request {
        Request { frame: FrameIndex(0), mode: Mode::Track, picture: Rgb8::new(Size::new(8, 8)) }
    }

    const HELLO: &str = r#"echo '{"protocol":"agenticfocus-hands/1","name":"fake"}'; "#;

    #[test]
    fn an_estimator_that_dies_is_quoted_with_its_status() {
        let error =
            EstimatorProcess::start(&shell("echo no such module >&2; exit 3"), 1).expect_err("it died");
        let text = error.to_string();
        assert!(text.contains("exit status: 3") && text.contains("no such module"), "{text}");
    }

    #[test]
    fn another_protocol_is_refused_by_name() {
        let error = EstimatorProcess::start(&shell(r#"echo '{"protocol":"hands/9"}'; sleep 5"#), 1);
        let text = error.expect_err("refused").to_string();
        assert!(text.contains("hands/9") && text.contains(PROTOCOL), "{text}");
    }

    #[test]
    fn a_silent_estimator_meets_its_time_out() {
        let mut process = EstimatorProcess::start(&shell(&format!("{HELLO} sleep 20")), 1).expect("started");
        assert!(matches!(process.ask(request()), Err(HandsError::TimedOut { .. })));
    }

    #[test]
    fn nonsense_is_refused_with_a_reason() {
        for (answer, reason) in [
            ("hello", "expected value"),
            (r#"{"id":7,"hands":[]}"#, "id is 7"),
            (r#"{"id":0,"hands":[{"side":"left","score":0.5,"keypoints":[[1,2]]}]}"#, "1 keypoints"),
        ] {
            let script = format!("{HELLO} echo '{answer}'; sleep 5");
            let mut process = EstimatorProcess::start(&shell(&script), 1).expect("started");
            let text = process.ask(request()).expect_err("refused").to_string();
            assert!(text.contains(reason), "{text} lacks {reason}");
        }
    }

    #[test]
    fn a_missing_program_is_named() {
        let error = EstimatorProcess::start(&EstimatorCommand::new("/no/such/program", []), 1);
        assert!(error.expect_err("missing").to_string().contains("/no/such/program"));
    }
}
