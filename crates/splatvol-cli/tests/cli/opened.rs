//! Pages that open files: what they show is what the command shows, and what they cannot read changes nothing.

use base64::Engine;
use serde_json::json;

use crate::browser::Browser;
use crate::data::{gaussian, sphere};
use crate::export::{bent_block, has_engine, in_browsers, opaque};
use crate::sandbox::{Sandbox, png};

#[test]
fn readers_are_in_pages_that_are_asked_to_open_files() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    let bytes = |flags: &str| {
        sandbox
            .run(&format!(
                "export sample:head:16 --no-webgpu --size 64 {flags} -o a.html -w"
            ))
            .succeeds();
        sandbox.bytes("a.html").len()
    };
    let readers = splatvol_page::readers().unwrap().len();
    let added = bytes("--open-files") - bytes("");
    assert!(
        (readers..readers * 3 / 2).contains(&added),
        "{added} of {readers}"
    );
}

#[test]
fn files_that_a_page_opens_are_shown_as_by_the_command() {
    in_browsers([500, 400], opens_files);
}

/// Files by their names, as the page gets them from a folder that is dropped.
fn given(sandbox: &Sandbox, names: &[&str]) -> String {
    let files = names.iter().map(|name| {
        let text = base64::engine::general_purpose::STANDARD.encode(sandbox.bytes(name));
        let file = name.rsplit('/').next();
        format!(
            "{{ path: {}, file: new File([Uint8Array.from(atob('{text}'), (c) => c.charCodeAt(0))], {}) }}",
            json!(name),
            json!(file)
        )
    });
    format!("[{}]", files.collect::<Vec<_>>().join(", "))
}

/// A slice of a cone, 20 x 20 pixels of grey.
fn slice(index: i32) -> Vec<u8> {
    let pixels = (0..400).map(|i: i32| ((i % 20 - 10).pow(2) + (i / 20 - 10).pow(2), 4 + 6 * index));
    let pixels: Vec<u8> = pixels
        .map(|(square, most)| if square < most { 200 - square as u8 } else { 0 })
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 20, 20);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().expect("it is a picture");
    writer.write_image_data(&pixels).expect("it has so many pixels");
    drop(writer);
    bytes
}

fn opens_files(browser: &Browser) {
    let sandbox = Sandbox::new();
    sandbox
        .run("export sample:tomato:16 --open-files --size 64 -o page.html")
        .succeeds();
    sandbox.write("ball.xyz", sphere(2000, [0.0; 3], Some([230, 60, 20])));
    sandbox.write("lone.ply", gaussian([0.9, 0.7, 0.1]));
    sandbox.write("bent.vtk", bent_block());
    sandbox.run("sample head --size 40 -o head.nrrd").succeeds();
    let samples = (0..24 * 24 * 24)
        .map(|i: i32| (i % 24 - 12).pow(2) + (i / 24 % 24 - 12).pow(2) + (i / 576 - 12).pow(2));
    sandbox.write(
        "pair.raw",
        samples.map(|square| square.min(255) as u8).collect::<Vec<_>>(),
    );
    sandbox.write(
        "pair.mhd",
        "ObjectType = Image\nNDims = 3\nDimSize = 24 24 24\nElementType = MET_UCHAR\nElementDataFile = pair.raw\n",
    );
    sandbox.run("sample shells --size 32 -o shells.npy").succeeds();
    for index in 0..12 {
        sandbox.write(&format!("slices/{index}.png"), slice(index));
    }
    let slices: Vec<String> = (0..12).map(|index| format!("slices/{index}.png")).collect();
    let slices: Vec<&str> = slices.iter().map(String::as_str).collect();
    sandbox.write(
        "two.toml",
        "[[item]]\nfile = \"ball.xyz\"\n[[item]]\nfile = \"lone.ply\"\n",
    );

    browser.requests();
    browser.open(&sandbox.path("page.html"));
    let picture = || browser.picture([120, 120]);
    let trouble = || browser.promised("document.getElementById('trouble').textContent");
    let in_trouble = |word: &str| {
        let said = trouble().to_string();
        assert!(said.contains(word), "{said}");
    };
    let mut last = picture();
    for (names, same) in [
        (&["ball.xyz"][..], "ball.xyz"),
        (&["lone.ply"], "lone.ply"),
        (&["bent.vtk"], "bent.vtk"),
        (&["head.nrrd"], "head.nrrd"),
        (&["pair.raw", "pair.mhd"], "pair.mhd"),
        (&["shells.npy"], "shells.npy"),
        (&slices, "slices"),
        (&["lone.ply", "ball.xyz"], "two.toml"),
    ] {
        let open = format!("splatvol.open({})", given(&sandbox, names));
        assert_eq!(browser.promised(&open), serde_json::Value::Null);
        assert_eq!(trouble(), "", "{same}");
        sandbox
            .run(&format!("render {same} --size 120 -o made.png -w"))
            .succeeds();
        let shown = picture();
        assert!(shown != last, "{same}: nothing has changed");
        assert!(opaque(&shown) == png(&sandbox.path("made.png")).2, "{same}");
        last = shown;
    }
    let title = browser.promised("document.title");
    assert_eq!(title, "ball.xyz, lone.ply");

    // By the button's input; and what is no data.
    sandbox.write("broken.nrrd", "NRRD0004\ntype: nothing\n\n");
    let choose = format!(
        "(() => {{ const all = new DataTransfer(); {}.forEach(({{ file }}) => all.items.add(file)); \
         const input = document.getElementById('files'); input.files = all.files; \
         input.dispatchEvent(new Event('change')); return splatvol.settled(); }})()",
        given(&sandbox, &["broken.nrrd"])
    );
    browser.promised(&choose);
    in_trouble("broken.nrrd");
    in_trouble("dimension");
    assert!(picture() == last, "what cannot be read changes the picture");

    // What a file leaves open is said in fields.
    sandbox.write(
        "bare.bin",
        (0..16 * 16 * 16)
            .map(|i: i32| (i % 16 * 16) as u8)
            .collect::<Vec<_>>(),
    );
    let fill = |label: &str, text: &str| {
        browser.promised(&format!(
            "(() => {{ const label = [...document.querySelectorAll('#open label')].find((made) => made.textContent === '{label}'); \
             document.getElementById(label.htmlFor).value = '{text}'; }})()"
        ));
    };
    let open = format!("splatvol.open({})", given(&sandbox, &["bare.bin"]));
    browser.promised(&open);
    in_trouble("layout");
    assert_eq!(
        browser.promised("document.querySelector('#open details').open"),
        true
    );
    fill("Raw: size", "16x16");
    fill("Raw: type", "u8");
    browser.promised(&open);
    in_trouble("array of length 3");
    fill("Raw: size", "16 x 16 x sixteen");
    browser.promised(&open);
    in_trouble("expected a number");
    assert!(picture() == last);
    fill("Raw: size", "16x16x16");
    browser.promised(&open);
    assert_eq!(trouble(), "");
    let run = "render bare.bin --dims 16,16,16 --type u8 --size 120 -o made.png -w";
    sandbox.run(run).succeeds();
    assert!(opaque(&picture()) == png(&sandbox.path("made.png")).2, "{run}");
    fill("Raw: size", "");
    fill("Raw: type", "");

    drops_files(browser, &sandbox);

    // The panel is that of what was opened, and it still turns.
    browser.promised(&format!("splatvol.open({})", given(&sandbox, &["head.nrrd"])));
    let first = picture();
    browser.promised("splatvol.settled()");
    browser.drag("#view", [90, 30]);
    assert!(picture() != first, "a drag turns nothing");
    let looks = browser.promised(
        "[...document.querySelectorAll('#controls h2')].filter((made) => made.textContent === 'Look').length",
    );
    assert_eq!(looks, 1);
    for url in browser.requests() {
        let own = url.ends_with("/page.html") && url.starts_with("file:");
        assert!(
            own || url.starts_with("blob:") || url.starts_with("data:"),
            "the page asks for {url}"
        );
    }
}

/// Drops by a script, as any browser hears them, and by the browser itself, where its driver can: a file and a folder.
fn drops_files(browser: &Browser, sandbox: &Sandbox) {
    let shown_as = |same: &str| {
        assert_eq!(
            browser.promised("document.getElementById('trouble').textContent"),
            ""
        );
        assert_eq!(
            browser.promised("document.body.classList.contains('dropping')"),
            false
        );
        sandbox
            .run(&format!("render {same} --size 120 -o made.png -w"))
            .succeeds();
        let shown = opaque(&browser.picture([120, 120]));
        assert!(shown == png(&sandbox.path("made.png")).2, "{same} is dropped");
    };
    let drop = format!(
        "(() => {{ const all = new DataTransfer(); {}.forEach(({{ file }}) => all.items.add(file)); \
         for (const kind of ['dragover', 'drop']) document.dispatchEvent(new DragEvent(kind, {{ dataTransfer: all, cancelable: true }})); \
         return splatvol.settled(); }})()",
        given(sandbox, &["ball.xyz"])
    );
    browser.promised(&drop);
    shown_as("ball.xyz");
    for name in ["lone.ply", "slices"] {
        let title = browser.promised("document.title");
        if browser.drop_files(&[&sandbox.path(name)], [200, 200]) {
            // The event may come after the driver's answer.
            browser.wait_until(&format!("document.title !== {title}"));
            browser.promised("splatvol.settled()");
            shown_as(name);
        }
    }
}
