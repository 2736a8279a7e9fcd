//! A child process whose pipes are read with time-outs: the cage for decoders of untrusted files.

use std::{
    io::{self, Read},
    os::fd::AsFd,
    process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio},
    time::{Duration, Instant},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::{Pid, Resource, Rlimit, prlimit},
};

/// Longest line of the child's log that is kept; the rest of a longer one is dropped.
const MAX_LINE: usize = 4096;

/// What a turn of [`Caged::wait_for`] brought.
#[derive(Debug, PartialEq, Eq)]
pub enum Turn {
    /// Bytes were appended to the output buffer.
    Output,
    /// Whole lines of the log were appended.
    Log,
    /// Nothing for now: the caller looks whether it still wants to wait.
    Idle,
    /// Both pipes are closed.
    Closed,
}

/// A running child with its standard output and error piped; killed and reaped when dropped.
#[derive(Debug)]
pub struct Caged {
    child: Child,
    stdout: Option<ChildStdout>,
    stderr: Option<ChildStderr>,
    line: Vec<u8>,
    last_sign_of_life: Instant,
}

impl Caged {
    /// Starts `command` without standard input, its address space limited to `memory` bytes.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn spawn(command: &mut Command, memory: u64) -> io::Result<Self> {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        // A limit that cannot be set is no reason to refuse: time-outs and size caps remain.
        let limit = Rlimit { current: Some(memory), maximum: Some(memory) };
        let _ = prlimit(Pid::from_raw(child.id() as i32), Resource::As, limit);
        let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
        Ok(Self { child, stdout, stderr, line: Vec::new(), last_sign_of_life: Instant::now() })
    }

    /// How long the child has been silent.
    pub fn silence(&self) -> Duration {
        self.last_sign_of_life.elapsed()
    }

    /// Waits at most half a second for the child: its output goes to the free part of `output`
    /// (`filled` says how much is taken; an empty free part leaves the output waiting in the
    /// pipe), its log to `log`, line by line.
    ///
    /// # Errors
    /// When a pipe cannot be read.
    pub fn wait_for(
        &mut self,
        output: &mut [u8],
        filled: &mut usize,
        log: &mut Vec<String>,
    ) -> io::Result<Turn> {
        let wants_output = *filled < output.len() || output.is_empty() && self.stderr.is_none();
        let (output_ready, log_ready) = self.poll(wants_output)?;
        let mut turn = Turn::Idle;
        if log_ready {
            self.read_log(log)?;
            turn = Turn::Log;
        }
        if output_ready && let Some(stdout) = &mut self.stdout {
            let count = stdout.read(&mut output[*filled..])?;
            *filled += count;
            if count == 0 {
                self.stdout = None;
            }
            turn = Turn::Output;
        }
        if turn != Turn::Idle {
            self.last_sign_of_life = Instant::now();
        }
        if self.stderr.is_none() && (self.stdout.is_none() || !wants_output) {
            return Ok(Turn::Closed);
        }
        Ok(turn)
    }

    fn poll(&self, wants_output: bool) -> io::Result<(bool, bool)> {
        let mut fds = Vec::with_capacity(2);
        let stdout = self.stdout.as_ref().filter(|_| wants_output);
        if let Some(pipe) = stdout {
            fds.push(PollFd::from_borrowed_fd(pipe.as_fd(), PollFlags::IN));
        }
        if let Some(pipe) = &self.stderr {
            fds.push(PollFd::from_borrowed_fd(pipe.as_fd(), PollFlags::IN));
        }
        if fds.is_empty() {
            return Ok((false, false));
        }
        match poll(&mut fds, Some(&Timespec { tv_sec: 0, tv_nsec: 500_000_000 })) {
            Ok(_) => {}
            Err(rustix::io::Errno::INTR) => return Ok((false, false)),
            Err(error) => return Err(error.into()),
        }
        let mut ready = fds.iter().map(|fd| !fd.revents().is_empty());
        let output_ready = stdout.is_some() && ready.next().unwrap_or(false);
        let log_ready = self.stderr.is_some() && ready.next().unwrap_or(false);
        Ok((output_ready, log_ready))
    }

    fn read_log(&mut self, log: &mut Vec<String>) -> io::Result<()> {
        let Some(stderr) = &mut self.stderr else { return Ok(()) };
        let mut chunk = [0; 8192];
        let count = stderr.read(&mut chunk)?;
        if count == 0 {
            self.stderr = None;
            self.end_line(log);
        }
        for byte in &chunk[..count] {
            match byte {
                b'\n' | b'\r' => self.end_line(log),
                byte if self.line.len() < MAX_LINE => self.line.push(*byte),
                _ => {}
            }
        }
        Ok(())
    }

    fn end_line(&mut self, log: &mut Vec<String>) {
        if !self.line.is_empty() {
            log.push(String::from_utf8_lossy(&self.line).into_owned());
            self.line.clear();
        }
    }

    /// Ends the child if it still runs, and says how it ended.
    ///
    /// # Errors
    /// When it cannot be waited for.
    pub fn finish(mut self, grace: Duration) -> io::Result<ExitStatus> {
        self.stdout = None;
        self.stderr = None;
        let deadline = Instant::now() + grace;
        loop {
            if let Some(status) = self.child.try_wait()? {
                return Ok(status);
            }
            if Instant::now() >= deadline {
                self.child.kill()?;
                return self.child.wait();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Caged {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a short-lived child left.
#[derive(Debug)]
pub struct Finished {
    /// Standard output.
    pub output: Vec<u8>,
    /// Lines of standard error.
    pub log: Vec<String>,
    /// How it ended; `None` when it was killed for being too slow or too talkative.
    pub status: Option<ExitStatus>,
}

/// Runs `command` to its end, at most `timeout` long, keeping at most `capacity` bytes of output.
///
/// # Errors
/// When it cannot be started or its pipes fail.
pub fn run_to_end(
    command: &mut Command,
    timeout: Duration,
    capacity: usize,
    memory: u64,
) -> io::Result<Finished> {
    let mut caged = Caged::spawn(command, memory)?;
    let started = Instant::now();
    let (mut output, mut filled, mut log) = (vec![0; capacity], 0, Vec::new());
    loop {
        let turn = caged.wait_for(&mut output, &mut filled, &mut log)?;
        log.truncate(64);
        if turn == Turn::Closed && filled < capacity {
            output.truncate(filled);
            return Ok(Finished { output, log, status: Some(caged.finish(Duration::from_secs(2))?) });
        }
        if started.elapsed() > timeout || filled == capacity {
            output.truncate(filled);
            return Ok(Finished { output, log, status: None });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn a_silent_child_is_given_up() {
        let started = Instant::now();
        let end = run_to_end(&mut shell("sleep 60"), Duration::from_millis(700), 100, 1 << 32).unwrap();
        assert!(end.status.is_none());
        assert!(started.elapsed() < Duration::from_secs(5));
    }

    #[test]
    fn output_and_log_of_a_child_are_kept_apart() {
        let script = "echo out; echo one >&2; echo two >&2; exit 3";
        let end = run_to_end(&mut shell(script), Duration::from_secs(10), 100, 1 << 32).unwrap();
        assert_eq!(end.output, b"out\n");
        assert_eq!(end.log, ["one", "two"]);
        assert_eq!(end.status.and_then(|status| status.code()), Some(3));
    }

    #[test]
    fn a_child_that_talks_without_end_is_cut() {
        let end = run_to_end(&mut shell("yes"), Duration::from_secs(10), 1000, 1 << 32).unwrap();
        assert_eq!((end.output.len(), end.status), (1000, None));
    }
}
