//! The program under clients that hold on to it: whoever sends a whole request is answered all the
//! same.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Clients that hold on, many more than the server has places.
const HELD: usize = 500;
/// Bytes of the scene: more than the system takes for a client who does not read.
const SCENE: u64 = 24 << 20;
/// Less than the server waits for a head, so that nobody waited for one that hangs; and as much as
/// a slow machine needs.
const SOON: Duration = Duration::from_secs(4);
/// One test at a time: each measures times, and has hundreds of connections.
static ALONE: Mutex<()> = Mutex::new(());

/// The program on a free port, with a page and a scene.
struct Program {
    child: Child,
    address: SocketAddr,
    folder: PathBuf,
}

impl Program {
    fn start() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("cullet-serve-load-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir_all(folder.join("page")).unwrap();
        fs::write(folder.join("page/index.html"), "page").unwrap();
        File::create(folder.join("scene.bin")).unwrap().set_len(SCENE).unwrap();
        let mut child = Command::new(env!("CARGO_BIN_EXE_cullet-serve"))
            .arg(folder.join("scene.bin"))
            .arg("--page")
            .arg(folder.join("page"))
            .args(["--port", "0"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.split("http://").nth(1).and_then(|l| l.split('/').next());
        let address = address.and_then(|a| a.parse().ok()).unwrap_or_else(|| panic!("{line}"));
        Self { child, address, folder }
    }

    /// Connections that have sent `request` and do no more.
    fn held(&self, request: &str) -> Vec<TcpStream> {
        let one = |_| {
            let mut stream = TcpStream::connect(self.address).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            stream
        };
        (0..HELD).map(one).collect()
    }

    /// How long a whole request takes until its answer of `bytes` is there.
    fn answered(&self, path: &str, bytes: u64) -> Duration {
        let asked = Instant::now();
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.write_all(whole(path).as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        assert!(answer.starts_with(b"HTTP/1.1 200 OK\r\n"), "{path}: {} bytes", answer.len());
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        assert_eq!((answer.len() - end - 4) as u64, bytes, "{path}");
        asked.elapsed()
    }

    /// Asks for page and scene again and again; none may take longer than `most`, nor the program
    /// more than its places need, while the first that hold on are not dropped yet and later.
    fn answers_within(&self, most: Duration) {
        for i in 0..10 {
            let page = self.answered("/", 4);
            let scene = self.answered("/scene/scene.bin", SCENE);
            println!("{i}: page {page:?}, scene {scene:?}");
            assert!(page < most && scene < most, "page {page:?}, scene {scene:?}");
            self.is_bounded();
        }
    }

    /// Threads, handles and KiB of memory that the program has now.
    #[cfg(target_os = "linux")]
    fn takes(&self) -> [u64; 3] {
        let of = format!("/proc/{}", self.child.id());
        let status = fs::read_to_string(format!("{of}/status")).unwrap();
        let value = |key: &str| {
            let line = status.lines().find_map(|l| l.strip_prefix(key)).unwrap();
            line.split_whitespace().next().unwrap().parse::<u64>().unwrap()
        };
        let handles = fs::read_dir(format!("{of}/fd")).unwrap().count() as u64;
        [value("Threads:"), handles, value("VmRSS:")]
    }

    /// It has a few threads, two handles a place, and the memory of its places.
    fn is_bounded(&self) {
        #[cfg(target_os = "linux")]
        {
            let [threads, handles, kib] = self.takes();
            println!("{threads} threads, {handles} handles, {kib} KiB");
            assert!(threads <= 8, "{threads} threads");
            assert!(handles <= 2 * 128 + 32, "{handles} handles");
            assert!(kib < 64 << 10, "{kib} KiB");
        }
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = fs::remove_dir_all(&self.folder);
    }
}

fn whole(path: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n")
}

/// Reads until the server has closed a connection, and tells what it said.
fn rest(stream: &mut TcpStream, most: Duration) -> Option<Vec<u8>> {
    let begun = Instant::now();
    stream.set_read_timeout(Some(most)).unwrap();
    let mut said = Vec::new();
    // A connection that is cut may end by a reset.
    let _ = stream.read_to_end(&mut said);
    (begun.elapsed() < most).then_some(said)
}

#[test]
fn half_heads_lock_nobody_out_and_are_dropped() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let program = Program::start();
    for request in ["", "GET / HTTP/1.1\r\nHost: local"] {
        let mut held = program.held(request);
        program.answers_within(SOON);
        let begun = Instant::now();
        for stream in &mut held {
            let said = rest(stream, Duration::from_secs(30));
            assert_eq!(said.as_deref(), Some(&b""[..]), "dropped, without an answer");
        }
        assert!(begun.elapsed() < Duration::from_secs(30), "{:?}", begun.elapsed());
    }
}

/// More answers, one after the other, than the server has places.
#[test]
fn a_place_is_free_again_after_its_answer() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let program = Program::start();
    for _ in 0..300 {
        program.answered("/", 4);
    }
    program.is_bounded();
}

#[test]
fn heads_and_bodies_that_trickle_lock_nobody_out() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let program = Program::start();
    let post = "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n";
    for (request, more) in [("GET / HTTP/1.1\r\n", "X: y\r\n"), (post, "x")] {
        let mut held = program.held(request);
        let done = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                // A head gets longer and longer; it has no more time for that.
                let begun = Instant::now();
                while !done.load(Ordering::Relaxed) || begun.elapsed() < Duration::from_secs(7) {
                    for stream in &mut held {
                        let _ = stream.write_all(more.as_bytes());
                    }
                    thread::sleep(Duration::from_millis(200));
                }
            });
            program.answers_within(SOON);
            done.store(true, Ordering::Relaxed);
        });
        for stream in &mut held {
            assert!(rest(stream, Duration::from_secs(2)).is_some(), "dropped after 7 seconds");
        }
    }
}

#[test]
fn whoever_takes_nothing_of_its_answer_locks_nobody_out() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let program = Program::start();
    // At first all places are theirs, until they have taken what the system takes for them, and no
    // more after.
    let held = program.held(&whole("/scene/scene.bin"));
    program.answers_within(Duration::from_secs(10));
    drop(held);
}

/// Each of 500 clients sends a byte a second; the server answers others, and ends when it is told
/// to.
#[cfg(unix)]
#[test]
fn a_byte_a_second_keeps_the_server_neither_busy_nor_alive() {
    let _alone = ALONE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut program = Program::start();
    let address = program.address;
    let done = AtomicBool::new(false);
    let (mut ended, mut took) = (None, Duration::ZERO);
    thread::scope(|scope| {
        scope.spawn(|| {
            let request = "GET /scene/scene.bin HTTP/1.1\r\nHost: localhost\r\nX: yyyyyyyyyyyy";
            let open = || (TcpStream::connect(address).ok(), 0);
            let mut slow: Vec<_> = (0..HELD).map(|_| open()).collect();
            while !done.load(Ordering::Relaxed) {
                for (stream, sent) in &mut slow {
                    let byte = &request.as_bytes()[*sent % request.len()..][..1];
                    *sent += 1;
                    // Whoever was dropped comes back.
                    if stream.as_mut().is_none_or(|s| s.write_all(byte).is_err()) {
                        (*stream, *sent) = open();
                    }
                }
                thread::sleep(Duration::from_secs(1));
            }
        });
        // Long enough for the first to be dropped, and to come back.
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(8) {
            program.answers_within(SOON);
        }
        let pid = program.child.id().to_string();
        let asked = Instant::now();
        assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        while ended.is_none() && asked.elapsed() < Duration::from_secs(20) {
            ended = program.child.try_wait().unwrap();
            thread::sleep(Duration::from_millis(5));
        }
        took = asked.elapsed();
        done.store(true, Ordering::Relaxed);
    });
    println!("ended after {took:?}");
    // Two seconds for answers that are under way, two for what still reads.
    assert!(took < Duration::from_secs(6), "{took:?}");
    assert_eq!(ended.and_then(|e| e.code()), Some(0), "{ended:?}");
}
