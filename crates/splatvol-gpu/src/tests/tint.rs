//! Tint: the compiler of WGSL in Chromium takes every shader and every entry point, within WebGPU's default limits.
//!
//! naga, with which wgpu compiles, takes barriers where invocations may part ways; Tint does not, and the browsers with it.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::layout::{every_shader, valid, variants};

/// Chromium with a device that it imitates itself.
const FLAGS: [&str; 8] = [
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
];
/// Longest time for all shaders.
const PATIENCE: Duration = Duration::from_secs(120);
/// Compiles all modules and their entry points, and says how many, or what was refused.
const SCRIPT: &str = r"
(async () => {
    const adapter = await navigator.gpu?.requestAdapter();
    if (!adapter) return 'no adapter';
    const device = await adapter.requestDevice();
    const refused = [];
    let compiled = 0;
    for (const { code, entries, constants } of shaders) {
        const module = device.createShaderModule({ code });
        const { messages } = await module.getCompilationInfo();
        refused.push(...messages.map((said) => `${entries}: line ${said.lineNum}: ${said.message}`));
        for (const entryPoint of messages.length ? [] : entries) {
            const pipeline = { layout: 'auto', compute: { module, entryPoint, constants } };
            await device.createComputePipelineAsync(pipeline)
                .then(() => { compiled += 1; }, (error) => refused.push(`${entryPoint}: ${error.message}`));
        }
    }
    return refused.length ? refused.join('\n') : `compiled ${compiled}`;
})().catch(String).then((said) => fetch('/', { method: 'POST', body: said }));
";

/// A page that compiles shaders, the first also to programs of their entry points; and the number of these.
fn page(shaders: &[String], variants: &[String]) -> (String, usize) {
    let mut count = 0;
    let mut list = String::new();
    for text in variants {
        writeln!(list, "{{ code: {text:?}, entries: [], constants: {{}} }},").unwrap();
    }
    for text in shaders {
        let module = valid(text);
        let entries: Vec<_> = module.entry_points.iter().map(|entry| &entry.name).collect();
        let open = module.overrides.iter().filter(|(_, own)| own.init.is_none());
        let constants: String = open
            .filter_map(|(_, own)| Some(format!("{}: 1,", own.name.as_ref()?)))
            .collect();
        count += entries.len();
        // Rust's literals of text and of lists are JavaScript's.
        writeln!(
            list,
            "{{ code: {text:?}, entries: {entries:?}, constants: {{{constants}}} }},"
        )
        .unwrap();
    }
    let page =
        format!("<!doctype html><meta charset='utf-8'><script>const shaders = [{list}];{SCRIPT}</script>");
    (page, count)
}

/// A running browser, which ends with the test, whatever becomes of that.
struct Browser(Child);

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a page posts to where it is from; `None` where there is no Chromium.
fn posted(page: &str) -> Option<String> {
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let address = format!("http://{}/", listener.local_addr().unwrap());
    let profile = tempfile::tempdir().unwrap();
    let started = Command::new("chromium")
        .args(FLAGS)
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(address)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _browser = Browser(started.ok()?);
    listener.set_nonblocking(true).unwrap();
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        match listener.accept() {
            Ok((stream, _)) => {
                if let Some(said) = answer(stream, page) {
                    return Some(said);
                }
            }
            Err(_) => std::thread::sleep(Duration::from_millis(20)),
        }
    }
    panic!("the browser says nothing");
}

/// Answers a request with the page; the text of one that posts.
fn answer(mut stream: TcpStream, page: &str) -> Option<String> {
    stream.set_nonblocking(false).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let mut line = String::new();
    let mut length = 0;
    let mut posts = false;
    // A browser opens connections that it does not use.
    while reader.read_line(&mut line).is_ok_and(|read| read > 0) {
        let header = line.trim().to_ascii_lowercase();
        if header.is_empty() {
            break;
        }
        posts |= header.starts_with("post ");
        if let Some(value) = header.strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        line.clear();
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).unwrap();
    let head = "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nConnection: close\r\nContent-Length:";
    // The browser may have gone.
    let _ = write!(stream, "{head} {}\r\n\r\n{page}", page.len());
    posts.then(|| String::from_utf8(body).unwrap())
}

#[test]
fn browsers_compile_every_shader() {
    let (page, count) = page(&every_shader(), &variants());
    match posted(&page) {
        Some(said) => assert_eq!(said, format!("compiled {count}")),
        None => splatvol_recorded::skip("Chromium is not installed"),
    }
}
