//! Requests as clients send them, good and bad, byte for byte.

use std::fs;
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::server::{Limits, Server};
use crate::site::{Site, SiteError};
use flate2::Compression;
use flate2::read::{GzDecoder, GzEncoder};

/// A folder of its own, removed when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let path =
            std::env::temp_dir().join(format!("cullet-serve-{}-{number}", std::process::id()));
        fs::create_dir_all(path.join("page/sub")).unwrap();
        let folder = Self(path);
        folder.file("page/index.html", b"<!doctype html>page");
        folder.file("page/viewer.wasm", &[7; 100_000]);
        let mut gzip = Vec::new();
        GzEncoder::new(&[7; 100_000][..], Compression::best()).read_to_end(&mut gzip).unwrap();
        folder.file("page/viewer.wasm.gz", &gzip);
        folder.file("page/notes.md", b"not of the page");
        folder.file("page/.hidden.js", b"hidden");
        folder.file("page/sub/inner.js", b"inner");
        folder.file("secret.txt", b"secret");
        folder.file("a scene.glb", &(0..1_000_000u32).map(|i| (i / 7) as u8).collect::<Vec<_>>());
        #[cfg(unix)]
        std::os::unix::fs::symlink(folder.0.join("secret.txt"), folder.0.join("page/link.txt"))
            .unwrap();
        folder
    }

    fn file(&self, name: &str, bytes: &[u8]) {
        fs::write(self.0.join(name), bytes).unwrap();
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

struct Running {
    address: SocketAddr,
    url: String,
    stop: tokio::sync::oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

/// A server of the folder's page and scene on a free port of `ip`.
fn start(folder: &Folder, ip: IpAddr, limits: Limits) -> Running {
    let scene = folder.at("a scene.glb");
    serve(Site::new(&folder.at("page"), scene.to_str()).unwrap(), ip, limits)
}

fn serve(site: Site, ip: IpAddr, limits: Limits) -> Running {
    let (tell, told) = mpsc::channel();
    let (stop, stopped) = tokio::sync::oneshot::channel();
    let thread = std::thread::spawn(move || {
        let server = Server::bind(SocketAddr::new(ip, 0), site, limits).unwrap();
        tell.send((server.address(), server.url())).unwrap();
        server.run_until(async {
            let _ = stopped.await;
        });
    });
    let (address, url) = told.recv().unwrap();
    Running { address, url, stop, thread }
}

fn local(folder: &Folder) -> Running {
    start(folder, Ipv4Addr::LOCALHOST.into(), Limits::default())
}

#[derive(Debug)]
struct Reply {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Reply {
    fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().find_map(|l| {
            let (key, value) = l.split_once(':')?;
            key.eq_ignore_ascii_case(name).then_some(value.trim())
        })
    }
}

impl Running {
    /// Sends bytes and reads to the end.
    fn raw(&self, request: &[u8]) -> Reply {
        let to = SocketAddr::new(Ipv4Addr::LOCALHOST.into(), self.address.port());
        let mut stream = TcpStream::connect(to).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        // A server that has seen enough closes while we still write.
        let _ = stream.write_all(request);
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let end = all.windows(4).position(|w| w == b"\r\n\r\n").unwrap_or(all.len());
        let head = String::from_utf8_lossy(&all[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
        Reply { status, head, body: all.get(end + 4..).unwrap_or_default().to_vec() }
    }

    fn ask(&self, method: &str, path: &str, headers: &str) -> Reply {
        let port = self.address.port();
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: close\r\n{headers}\r\n"
        );
        self.raw(request.as_bytes())
    }

    fn get(&self, path: &str) -> Reply {
        self.ask("GET", path, "")
    }

    fn end(self) {
        let _ = self.stop.send(());
        self.thread.join().unwrap();
    }
}

#[test]
fn the_page_and_its_files_come_with_types_tags_and_gzip() {
    let folder = Folder::new();
    let server = local(&folder);
    for path in ["/", "/index.html", "/?webgl", "/index.html?x=../.."] {
        let reply = server.get(path);
        assert_eq!((reply.status, &reply.body[..]), (200, &b"<!doctype html>page"[..]), "{path}");
        assert_eq!(reply.header("content-type"), Some("text/html; charset=utf-8"));
        assert_eq!(reply.header("x-content-type-options"), Some("nosniff"));
        assert!(reply.header("content-security-policy").unwrap().contains("wasm-unsafe-eval"));
    }
    let plain = server.get("/viewer.wasm");
    assert_eq!(plain.header("content-type"), Some("application/wasm"));
    assert_eq!((plain.body.len(), plain.header("content-encoding")), (100_000, None));
    let gzip = server.ask("GET", "/viewer.wasm", "Accept-Encoding: br, gzip\r\n");
    assert_eq!(gzip.header("content-encoding"), Some("gzip"));
    assert_eq!(gzip.header("vary"), Some("Accept-Encoding"));
    assert!(gzip.body.len() < 1000, "{} bytes", gzip.body.len());
    let mut back = Vec::new();
    GzDecoder::new(&gzip.body[..]).read_to_end(&mut back).unwrap();
    assert_eq!(back, plain.body);
    assert_ne!(gzip.header("etag"), plain.header("etag"), "a cache must tell the forms apart");
    let again = format!("If-None-Match: {}\r\n", plain.header("etag").unwrap());
    let known = server.ask("GET", "/viewer.wasm", &again);
    assert_eq!((known.status, known.body.len()), (304, 0));
    let head = server.ask("HEAD", "/viewer.wasm", "");
    assert_eq!((head.status, head.body.len()), (200, 0));
    assert_eq!(head.header("content-length"), Some("100000"));
    server.end();
}

#[test]
fn the_scene_is_found_by_its_name_alone() {
    let folder = Folder::new();
    let server = local(&folder);
    assert!(server.url.ends_with("/#scene=/scene/a%20scene.glb"), "{}", server.url);
    let reply = server.get("/scene/a%20scene.glb");
    assert_eq!(reply.status, 200, "{}", reply.head);
    assert_eq!(reply.header("content-type"), Some("model/gltf-binary"));
    assert_eq!(reply.header("content-length"), Some("1000000"));
    assert_eq!(reply.body, fs::read(folder.at("a scene.glb")).unwrap());
    assert_eq!(server.ask("HEAD", "/scene/a%20scene.glb", "").body.len(), 0);
    let tag = format!("If-None-Match: \"x\", W/{}\r\n", reply.header("etag").unwrap());
    assert_eq!(server.ask("GET", "/scene/a%20scene.glb", &tag).status, 304);
    for path in ["/scene/", "/scene", "/scene/secret.txt", "/scene/../secret.txt", "/a%20scene.glb"]
    {
        assert_eq!(server.get(path).status, 404, "{path}");
    }
    fs::remove_file(folder.at("a scene.glb")).unwrap();
    assert_eq!(server.get("/scene/a%20scene.glb").status, 404);
    server.end();
}

/// The folder's own scene is a glTF with buffers.
const GLTF: &str = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"parts/the%20one.bin"},
    {"byteLength":4,"uri":"link.bin"},{"byteLength":4,"uri":"none.bin"},{"byteLength":4,"uri":"../secret.txt"},
    {"byteLength":4,"uri":"/etc/passwd"},{"byteLength":4,"uri":"parts"}]}"#;

#[test]
fn what_a_scene_names_is_served_and_nothing_beside_it() {
    let folder = Folder::new();
    fs::create_dir_all(folder.at("models/parts")).unwrap();
    folder.file("models/a.gltf", GLTF.as_bytes());
    folder.file("models/parts/the one.bin", b"data");
    folder.file("models/parts/other.bin", b"other");
    folder.file("models/near.bin", b"near");
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.at("secret.txt"), folder.at("models/link.bin")).unwrap();
    let scene = folder.at("models/a.gltf");
    let site = Site::new(&folder.at("page"), scene.to_str()).unwrap();
    let named = |n: &str| format!("{} names {n}, which is not in its folder", scene.display());
    let expected = ["link.bin", "none.bin", "parts"].map(named);
    assert_eq!(site.warnings(), expected);
    let server = serve(site, Ipv4Addr::LOCALHOST.into(), Limits::default());
    assert!(server.url.ends_with("/#scene=/scene/a.gltf"), "{}", server.url);
    let named = server.get("/scene/parts/the%20one.bin");
    assert_eq!((named.status, &named.body[..]), (200, &b"data"[..]));
    assert_eq!(named.header("content-type"), Some("application/octet-stream"));
    assert_eq!(server.get("/scene/a.gltf").body, GLTF.as_bytes());
    for path in [
        "/scene/parts/other.bin",
        "/scene/near.bin",
        "/scene/link.bin",
        "/scene/none.bin",
        "/scene/parts",
        "/scene/parts/",
        "/scene/parts/../near.bin",
        "/scene/../secret.txt",
        "/scene//etc/passwd",
        "/scene/the%20one.bin",
        "/parts/the%20one.bin",
    ] {
        assert_eq!(server.get(path).status, 404, "{path}");
    }
    assert_eq!(server.get("/scene/parts%2fthe%20one.bin").status, 400);
    server.end();
}

#[test]
fn nothing_else_is_served_however_it_is_asked_for() {
    let folder = Folder::new();
    let server = local(&folder);
    let secret = folder.at("secret.txt");
    let absolute = secret.to_str().unwrap();
    let paths = [
        "/../secret.txt",
        "/..",
        "/.",
        "//index.html",
        "/./index.html",
        "/sub/inner.js",
        "/sub",
        "/link.txt",
        "/.hidden.js",
        "/notes.md",
        "/viewer.wasm.gz",
        "/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "/%2e%2e%2fsecret.txt",
        "/..%5csecret.txt",
        "/..\\secret.txt",
        "/%252e%252e%252fsecret.txt",
        "/%c0%ae%c0%ae/secret.txt",
        "/%00",
        "/index.html%00.js",
        "/index.html/",
        "/INDEX.HTML",
        "/%",
        "/%zz",
        "/%u002e",
        absolute,
        "/etc/passwd",
        "//etc/passwd",
        "/file:///etc/passwd",
        "/scene/%2e%2e%2fsecret.txt",
        "/index.html;x",
        "/\u{7f}",
        "/index.html.",
    ];
    for path in paths {
        let reply = server.get(path);
        assert!(matches!(reply.status, 400 | 404), "{path}: {}", reply.head);
        let body = String::from_utf8_lossy(&reply.body);
        for kept in ["secret", "inner", "hidden", "not of the page", "root:"] {
            assert!(!body.contains(kept), "{path} gave {body}");
        }
    }
    for raw in ["GET /index.html", "GET http://evil.example/", "GET ../secret.txt", "GET *", "GET "]
    {
        let port = server.address.port();
        let text = format!("{raw} HTTP/1.1\r\nHost: localhost:{port}\r\nConnection: close\r\n\r\n");
        let expected = if raw == "GET /index.html" { 200..=200 } else { 400..=499 };
        let reply = server.raw(text.as_bytes());
        assert!(expected.contains(&reply.status), "{raw}: {}", reply.head);
    }
    server.end();
}

#[test]
fn other_methods_bodies_and_heads_beyond_the_limits_are_refused() {
    let folder = Folder::new();
    let server = local(&folder);
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH"] {
        let reply = server.ask(method, "/", "");
        assert_eq!((reply.status, reply.header("allow")), (405, Some("GET, HEAD")), "{method}");
    }
    assert_eq!(server.ask("GET", "/", "Content-Length: 99999999999\r\n").status, 413);
    assert_eq!(server.ask("GET", "/", "Transfer-Encoding: chunked\r\n").status, 413);
    assert_eq!(server.ask("GET", "/", "Content-Length: 0\r\n").status, 200);
    assert_eq!(server.get(&format!("/{}", "a".repeat(4000))).status, 414);
    assert_eq!(server.ask("GET", "/", &"X: y\r\n".repeat(100)).status, 431);
    let long = format!("X: {}\r\n", "y".repeat(200_000));
    let reply = server.ask("GET", "/", &long);
    assert!(matches!(reply.status, 0 | 431), "{}", reply.head);
    assert_eq!(server.raw(b"nonsense\r\n\r\n").status, 400);
    // It still serves after all that.
    assert_eq!(server.get("/").status, 200);
    server.end();
}

#[test]
fn names_of_other_sites_do_not_lead_here() {
    let folder = Folder::new();
    let server = local(&folder);
    let with_host = |host: &str| {
        let text = format!("GET / HTTP/1.1\r\n{host}Connection: close\r\n\r\n");
        server.raw(text.as_bytes()).status
    };
    for good in ["localhost", "localhost:1", "127.0.0.1:80", "[::1]:80", "[::1]", "LocalHost:9"] {
        assert_eq!(with_host(&format!("Host: {good}\r\n")), 200, "{good}");
    }
    for bad in
        ["evil.example", "localhost.evil.example:80", "10.0.0.1", "127.0.0.1.evil.example", ""]
    {
        assert_eq!(with_host(&format!("Host: {bad}\r\n")), 421, "{bad}");
    }
    assert_eq!(with_host(""), 421);
    assert_eq!(with_host("Host: localhost\r\nHost: localhost\r\n"), 421);
    server.end();
}

#[test]
fn on_a_network_scenes_are_compressed_on_the_way() {
    let folder = Folder::new();
    let server = start(&folder, Ipv4Addr::UNSPECIFIED.into(), Limits::default());
    assert!(server.url.starts_with("http://127.0.0.1:"), "{}", server.url);
    let reply = server.ask("GET", "/scene/a%20scene.glb", "Accept-Encoding: gzip\r\n");
    assert_eq!(reply.header("content-encoding"), Some("gzip"));
    assert!(reply.body.len() < 200_000, "{}", reply.body.len());
    assert_eq!(server.get("/scene/a%20scene.glb").header("content-length"), Some("1000000"));
    server.end();
}

#[test]
fn it_stops_though_clients_hang_on() {
    let folder = Folder::new();
    let limits = Limits {
        stop_time: Duration::from_millis(300),
        head_time: Duration::from_millis(400),
        ..Limits::default()
    };
    let server = start(&folder, Ipv4Addr::LOCALHOST.into(), limits);
    let port = server.address.port();
    let mut slow = TcpStream::connect(server.address).unwrap();
    slow.write_all(b"GET / HTTP/1.1\r\nHost: local").unwrap();
    // One that never ends its head is sent away.
    slow.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let asked = Instant::now();
    let mut rest = Vec::new();
    let _ = slow.read_to_end(&mut rest);
    assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
    // One that asks for the scene and does not read it.
    let mut stuck = TcpStream::connect(server.address).unwrap();
    let request = format!("GET /scene/a%20scene.glb HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n");
    stuck.write_all(request.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(100));
    let start = Instant::now();
    let address = server.address;
    server.end();
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
    assert!(TcpStream::connect(address).is_err(), "the port is free again");
}

#[test]
fn what_cannot_be_served_is_said_at_the_start() {
    let folder = Folder::new();
    let page = folder.at("page");
    let new =
        |page: &Path, scene: &str| Site::new(page, Some(scene)).map(|s| s.fragment().to_owned());
    assert_eq!(new(&page, "city:seed=3").unwrap(), "#scene=city:seed%3D3");
    let text = |r: Result<String, SiteError>| r.unwrap_err().to_string();
    let message = text(new(&page, "nowhere.glb"));
    assert!(message.contains("nowhere.glb") && message.contains("city"), "{message}");
    let message = text(new(&page, "city:seeds=3"));
    assert!(message.contains("seeds") && !message.contains("built in"), "{message}");
    let message = text(new(&page, page.to_str().unwrap()));
    assert!(message.contains("is a folder"), "{message}");
    // A file that cannot be read as a scene is served even so, for the page says the same.
    folder.file("broken.gltf", b"{");
    let broken = Site::new(&page, folder.at("broken.gltf").to_str()).unwrap();
    let [warning] = broken.warnings() else { panic!("{:?}", broken.warnings()) };
    assert!(warning.contains("broken.gltf"), "{warning}");
    let message = text(new(&folder.at("page/sub"), "city"));
    assert!(message.contains("index.html") && message.contains("cargo xtask web"), "{message}");
    let message = text(new(&folder.at("absent"), "city"));
    assert!(message.contains("cargo xtask web"), "{message}");
}
