//! From a request to an answer.

use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Read;
use std::net::IpAddr;

use flate2::Compression;
use flate2::read::GzEncoder;
use hyper::header::{self, HeaderMap, HeaderValue};
use hyper::http::response::Builder;
use hyper::{Method, Request, Response, StatusCode};

use crate::body::Answer;
use crate::site::{PageFile, SCENE_FOLDER, SceneFile, Site};

/// The page runs its own code and nobody else's; `wasm-unsafe-eval` is what compiling wasm is
/// called.
const POLICY: &str = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; \
                      style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self' blob: data:; worker-src 'self' blob:; object-src 'none'; \
                      base-uri 'none'; form-action 'none'";

/// Answers to the requests of one server.
#[derive(Debug)]
pub(crate) struct Answers {
    pub(crate) site: Site,
    /// The address listened on.
    pub(crate) ip: IpAddr,
    /// The longest address of a request, in bytes.
    pub(crate) max_target: usize,
}

impl Answers {
    /// Answers a request; its body is not read. Only opening the scene's file can wait.
    pub(crate) fn to<B>(&self, request: &Request<B>) -> Response<Answer> {
        let (method, uri, headers) = (request.method(), request.uri(), request.headers());
        if uri.path_and_query().map_or(0, |p| p.as_str().len()) > self.max_target {
            return refuse(StatusCode::URI_TOO_LONG, "the address is too long");
        }
        if method != Method::GET && method != Method::HEAD {
            let mut answer =
                refuse(StatusCode::METHOD_NOT_ALLOWED, "only GET and HEAD are answered");
            answer.headers_mut().insert(header::ALLOW, HeaderValue::from_static("GET, HEAD"));
            return answer;
        }
        if has_body(headers) {
            return refuse(StatusCode::PAYLOAD_TOO_LARGE, "a request has no body here");
        }
        // A name of another site that was made to lead here must not read what is served (DNS
        // rebinding).
        if uri.authority().is_some() || !self.is_our_name(headers) {
            return refuse(StatusCode::MISDIRECTED_REQUEST, "this server is not called that");
        }
        let Some(path) = decode(uri.path()) else {
            return refuse(StatusCode::BAD_REQUEST, "the address is not text");
        };
        let scene = path.strip_prefix(SCENE_FOLDER);
        let mut answer = match scene.and_then(|name| self.site.scene.get(name)) {
            Some(file) => self.scene(file, headers),
            None => {
                let name =
                    if path == "/" { "index.html" } else { path.get(1..).unwrap_or_default() };
                match self.site.page.get(name) {
                    Some(file) if path.starts_with('/') => page(file, headers),
                    _ => refuse(StatusCode::NOT_FOUND, "there is nothing here"),
                }
            }
        };
        if method == Method::HEAD {
            // The size stays in the headers; the body goes.
            if let Answer::Whole(Some(bytes)) = answer.body() {
                let length = HeaderValue::from(bytes.len());
                answer.headers_mut().insert(header::CONTENT_LENGTH, length);
            }
            *answer.body_mut() = Answer::Whole(None);
        }
        answer
    }

    fn is_our_name(&self, headers: &HeaderMap) -> bool {
        let mut hosts = headers.get_all(header::HOST).iter();
        let (Some(host), None) = (hosts.next(), hosts.next()) else { return false };
        // Whoever listens on a network is called by whatever names that network gives.
        if !self.ip.is_loopback() {
            return true;
        }
        let Ok(host) = host.to_str() else { return false };
        let name = match host.rsplit_once(':') {
            Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
            _ => host,
        };
        let bare = name.strip_prefix('[').and_then(|n| n.strip_suffix(']')).unwrap_or(name);
        name.eq_ignore_ascii_case("localhost")
            || bare.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
    }

    fn scene(&self, file: &SceneFile, headers: &HeaderMap) -> Response<Answer> {
        let open = || {
            let opened = File::open(&file.path)?;
            let meta = opened.metadata()?;
            Ok::<_, std::io::Error>((opened, meta))
        };
        let Ok((opened, meta)) = open() else {
            return refuse(StatusCode::NOT_FOUND, "the scene's file is gone");
        };
        let mut hasher = DefaultHasher::new();
        (meta.len(), meta.modified().ok()).hash(&mut hasher);
        let tag = hasher.finish();
        // On the same machine, compressing takes longer than sending.
        let gzip = !self.ip.is_loopback() && accepts_gzip(headers);
        let (answer, fresh) = begin(file.kind, tag, gzip, headers);
        if fresh {
            return finish(answer, Answer::Whole(None));
        }
        // Bytes appended to the file meanwhile are not sent: the length has been promised.
        let source = opened.take(meta.len());
        if gzip {
            return finish(
                answer,
                Answer::reading(GzEncoder::new(source, Compression::fast()), None),
            );
        }
        let answer = answer.header(header::CONTENT_LENGTH, meta.len());
        finish(answer, Answer::reading(source, Some(meta.len())))
    }
}

fn page(file: &PageFile, headers: &HeaderMap) -> Response<Answer> {
    let gzip = file.gzip.as_ref().filter(|_| accepts_gzip(headers));
    let (answer, fresh) = begin(file.kind, file.tag, gzip.is_some(), headers);
    let body = if fresh {
        Answer::Whole(None)
    } else {
        Answer::whole(gzip.unwrap_or(&file.bytes).clone())
    };
    finish(answer.header("Content-Security-Policy", POLICY), body)
}

/// The head of an answer, and whether the client has it already.
fn begin(kind: &'static str, tag: u64, gzip: bool, headers: &HeaderMap) -> (Builder, bool) {
    // The two forms of a file are two entries of a cache.
    let tag = format!("\"{tag:016x}{}\"", if gzip { "-gz" } else { "" });
    let known = headers.get_all(header::IF_NONE_MATCH).iter();
    let fresh = known.filter_map(|v| v.to_str().ok()).flat_map(|v| v.split(',')).any(|v| {
        let v = v.trim();
        v == "*" || v.trim_start_matches("W/") == tag
    });
    let answer = Response::builder()
        .status(if fresh { StatusCode::NOT_MODIFIED } else { StatusCode::OK })
        .header(header::CONTENT_TYPE, kind)
        .header(header::ETAG, tag)
        // Kept, but revalidated each time: a page that was built anew is seen at once.
        .header(header::CACHE_CONTROL, "no-cache")
        .header(header::VARY, "Accept-Encoding");
    (if gzip { answer.header(header::CONTENT_ENCODING, "gzip") } else { answer }, fresh)
}

fn refuse(status: StatusCode, why: &str) -> Response<Answer> {
    let answer = Response::builder()
        .status(status)
        .header(header::CONTENT_TYPE, "text/plain; charset=utf-8")
        .header(header::CACHE_CONTROL, "no-store");
    // The unread rest of a request must not be taken for the next one.
    let stay = status == StatusCode::NOT_FOUND;
    let answer = if stay { answer } else { answer.header(header::CONNECTION, "close") };
    finish(answer, Answer::whole(format!("{why}\n").into_bytes()))
}

fn finish(answer: Builder, body: Answer) -> Response<Answer> {
    let answer = answer
        .header(header::X_CONTENT_TYPE_OPTIONS, "nosniff")
        .header(header::REFERRER_POLICY, "no-referrer")
        .header("Cross-Origin-Resource-Policy", "same-origin")
        .body(body);
    // Only a header that is no text could fail, and all are ours; even so nothing is served
    // wrongly.
    answer.unwrap_or_else(|_| {
        let mut failed = Response::new(Answer::Whole(None));
        *failed.status_mut() = StatusCode::INTERNAL_SERVER_ERROR;
        failed
    })
}

fn has_body(headers: &HeaderMap) -> bool {
    let length = headers.get(header::CONTENT_LENGTH);
    headers.contains_key(header::TRANSFER_ENCODING) || length.is_some_and(|l| l.as_bytes() != b"0")
}

fn accepts_gzip(headers: &HeaderMap) -> bool {
    let all = headers.get_all(header::ACCEPT_ENCODING).iter().filter_map(|v| v.to_str().ok());
    let mut coding = all.flat_map(|v| v.split(','));
    coding.any(|c| {
        let mut parts = c.split(';').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let quality = parts.find_map(|p| p.strip_prefix("q=")).map_or(Ok(1.0), str::parse::<f32>);
        name.eq_ignore_ascii_case("gzip") && quality.is_ok_and(|q| q > 0.0)
    })
}

/// A path without percent signs; `None` if they make no text, or hide what divides paths.
fn decode(path: &str) -> Option<String> {
    let mut out = Vec::with_capacity(path.len());
    let mut bytes = path.bytes();
    while let Some(b) = bytes.next() {
        if b != b'%' {
            out.push(b);
            continue;
        }
        let digit = |b: Option<u8>| char::from(b?).to_digit(16);
        let value = (digit(bytes.next())? * 16 + digit(bytes.next())?) as u8;
        if value.is_ascii_control() || value == b'/' || value == b'\\' {
            return None;
        }
        out.push(value);
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_signs_are_read_strictly() {
        assert_eq!(decode("/scene/a%20b.glb").as_deref(), Some("/scene/a b.glb"));
        assert_eq!(decode("/%2e%2e").as_deref(), Some("/.."));
        assert_eq!(decode("/%252e").as_deref(), Some("/%2e"), "decoded once, not twice");
        for invalid in ["/%", "/%2", "/%zz", "/%00", "/%0a", "/a%2fb", "/a%5Cb", "/%ff", "/%c0%ae"]
        {
            assert_eq!(decode(invalid), None, "{invalid}");
        }
    }

    #[test]
    fn gzip_is_sent_to_whoever_wants_it() {
        let accepts = |v: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT_ENCODING, HeaderValue::from_static(v));
            accepts_gzip(&headers)
        };
        assert!(accepts("gzip") && accepts("br, GZIP;q=0.5") && accepts("deflate,gzip"));
        assert!(!accepts("br") && !accepts("gzip;q=0") && !accepts("") && !accepts("gzip;q=x"));
    }
}
