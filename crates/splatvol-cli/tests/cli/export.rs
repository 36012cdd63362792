//! Pages: what is refused, how they fit, and what a browser makes of them.

use std::sync::Mutex;

use crate::browser::{Browser, Kind};
use crate::data::{gaussian, sphere};
use crate::sandbox::{Sandbox, png};

/// Whether the command has the engine for browsers, of its own sources; says so where it has not.
pub(crate) fn has_engine() -> bool {
    let has = splatvol_page::engine().is_ok() && splatvol_page::outdated().is_none();
    if !has {
        splatvol_recorded::skip(
            "the engine for browsers was not built of these sources (cargo xtask web --dev)",
        );
    }
    has
}

/// Browsers take much memory: one at a time.
static ONE: Mutex<()> = Mutex::new(());

/// Shows something in each browser that there is.
pub(crate) fn in_browsers(size: [u32; 2], show: impl Fn(&Browser)) {
    if !has_engine() {
        return;
    }
    let _one = ONE.lock();
    for kind in Kind::ALL {
        if let Some(browser) = Browser::start(kind, size) {
            show(&browser);
        }
    }
}

#[test]
fn without_an_engine_of_its_own_the_command_says_how_to_get_it() {
    let sandbox = Sandbox::new();
    let run = sandbox.run("export sample:head:16 --size 32 -o a.html");
    if splatvol_page::engine().is_err() {
        run.fails(2, &["engine for browsers", "cargo xtask web"]);
        assert!(sandbox.files().is_empty());
        return;
    }
    let said = run.succeeds().stderr();
    let lines = said.lines().filter(|line| line.contains("engine for browsers"));
    let lines: Vec<&str> = lines.collect();
    match splatvol_page::outdated() {
        Some(sentence) => assert_eq!(lines, [format!("splatvol: warning: {sentence}")]),
        None => assert!(lines.is_empty(), "{said}"),
    }
    assert!(!sandbox.bytes("a.html").is_empty());
}

#[test]
fn what_a_page_cannot_show_is_refused_by_name() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    for (arguments, words) in [
        ("sample:head:16 --bits 16", ["--bits 16", "cannot show"]),
        (
            "sample:head:16 --spin 20 --classification pre --motion-blur exact",
            ["motion blur", "cannot show"],
        ),
        (
            "sample:head:16 --max-size 100K",
            ["--max-size", "without the data"],
        ),
    ] {
        sandbox
            .run(&format!("export {arguments} -o a.html"))
            .fails(2, &words);
    }
    sandbox.run("export missing.nrrd").fails(3, &["missing.nrrd"]);
    sandbox
        .run("export sample:head:16 -o none/a.html")
        .fails(5, &["none"]);
    assert!(sandbox.files().is_empty());
    sandbox.write("b.html", "mine");
    sandbox
        .run("export sample:head:16 -o b.html")
        .fails(5, &["already exists"]);
}

#[test]
fn the_report_says_what_fits_and_how_far_the_picture_is() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    let report = |arguments: &str, name: &str| -> serde_json::Value {
        let run = format!(
            "export sample:head:64 --size 128 --no-webgpu {arguments} -o {name}.html --report {name}.json"
        );
        let said = sandbox.run(&run).succeeds().stderr();
        assert!(
            said.contains("dB (PSNR)") || said.contains("that of all data, in 8 bits"),
            "{said}"
        );
        let report: serde_json::Value =
            serde_json::from_slice(&sandbox.bytes(&format!("{name}.json"))).unwrap();
        assert_eq!(report["bytes"], sandbox.bytes(&format!("{name}.html")).len());
        report
    };
    let whole = report("", "whole");
    assert_eq!(
        (&whole["exact"], &whole["psnr"]),
        (&true.into(), &serde_json::Value::Null)
    );
    let eight = report("--quantize 8", "eight");
    assert_eq!(
        (&eight["exact"], &eight["bits"], &eight["level"]),
        (&false.into(), &8.into(), &0.into())
    );
    let psnr = eight["psnr"].as_f64().unwrap();
    assert!((40.0..90.0).contains(&psnr), "{psnr}");
    // Room for less than the samples in 8 bits.
    let bytes = eight["bytes"].as_u64().unwrap() - eight["data-bytes"].as_u64().unwrap() / 2;
    let small = report(&format!("--max-size {bytes}"), "small");
    assert!(
        small["bytes"].as_u64().unwrap() <= bytes && small["level"].as_u64().unwrap() > 0,
        "{small}"
    );
    assert!(small["psnr"].as_f64().unwrap() < psnr);
}

/// Data come first: a page that would be too large with it has no WebGPU.
#[test]
fn webgpu_is_in_pages_that_have_room_for_it() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    let report = |arguments: &str| -> (bool, u64, serde_json::Value, String) {
        let run = format!("export sample:head:32 --size 64 {arguments} -o a.html --report a.json -w");
        let said = sandbox.run(&run).succeeds().stderr();
        let report: serde_json::Value = serde_json::from_slice(&sandbox.bytes("a.json")).unwrap();
        let bytes = report["bytes"].as_u64().unwrap();
        (
            report["webgpu"].as_bool().unwrap(),
            bytes,
            report["exact"].clone(),
            said,
        )
    };
    let (without, least, _, said) = report("--no-webgpu");
    assert!(!without && !said.contains("WebGPU"), "{said}");
    let (has, bytes, ..) = report("");
    let Some(webgpu) = splatvol_page::webgpu() else {
        assert!(!has);
        splatvol_recorded::skip(
            "the GPU engine for browsers was not built of these sources (cargo xtask-webgpu --dev)",
        );
        return;
    };
    assert!(
        has && bytes > least + webgpu.module.len() as u64,
        "{bytes} {least}"
    );
    let (has, bytes, exact, said) = report(&format!("--max-size {}", bytes - 1));
    assert!(!has && bytes <= least + 100 && exact == true, "{bytes} {least}");
    assert!(said.contains("WebGPU") && said.contains("--max-size"), "{said}");
}

#[test]
fn points_become_fewer_and_gaussians_lose_harmonics_until_they_fit() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    sandbox.write("ball.xyz", sphere(20_000, [0.0; 3], Some([230, 60, 20])));
    let report = |arguments: &str| -> serde_json::Value {
        let run =
            format!("export ball.xyz --size 160 --no-webgpu {arguments} -o ball.html --report ball.json -w");
        sandbox.run(&run).succeeds();
        serde_json::from_slice(&sandbox.bytes("ball.json")).unwrap()
    };
    let whole = report("");
    assert_eq!(
        (
            &whole["items"][0]["kind"],
            &whole["items"][0]["count"],
            &whole["level"]
        ),
        (&"points".into(), &20_000.into(), &0.into())
    );
    assert!(
        whole["psnr"].is_null() || whole["psnr"].as_f64() > Some(60.0),
        "{whole}"
    );
    let data = whole["data-bytes"].as_u64().unwrap();
    let most = whole["bytes"].as_u64().unwrap() - data;
    let small = report(&format!("--max-size {most}"));
    let count = small["items"][0]["count"].as_u64().unwrap();
    assert!(small["level"] == 1 && (4500..5500).contains(&count), "{small}");
    assert!(small["psnr"].as_f64() > Some(18.0), "{small}");

    sandbox.write("lone.ply", gaussian([0.9, 0.7, 0.1]));
    let said = sandbox
        .run("export lone.ply --size 64 -o lone.html")
        .succeeds()
        .stderr();
    assert!(said.contains("1 Gaussians, harmonics of degree 0"), "{said}");
}

#[test]
fn a_page_holds_no_path_and_no_text_of_the_file() {
    if !has_engine() {
        return;
    }
    let sandbox = Sandbox::new();
    sandbox
        .run("sample head --size 16 -o secret-folder.nrrd")
        .succeeds();
    let below = sandbox.below("elsewhere");
    below.write("patient.nrrd", sandbox.bytes("secret-folder.nrrd"));
    let run = "export elsewhere/patient.nrrd --size 64 --title <b>&\"scan\" -o page.html";
    sandbox.run(run).succeeds();
    let page = String::from_utf8(sandbox.bytes("page.html")).unwrap();
    assert!(page.contains("<title>&lt;b&gt;&amp;&quot;scan&quot;</title>"));
    assert!(!page.contains("elsewhere") && page.contains("\"file\":\"patient\""));
}

#[test]
fn a_page_opens_from_disk_turns_and_asks_nobody() {
    in_browsers([900, 700], opens_turns_and_asks_nobody);
}

fn opens_turns_and_asks_nobody(browser: &Browser) {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:head:64 --view front --size 240x200 -o head.png")
        .succeeds();
    sandbox.run("export --like head.png -o head.html").succeeds();
    let (_, _, expected) = png(&sandbox.path("head.png"));
    browser.requests();
    browser.open(&sandbox.path("head.html"));
    assert!(
        browser.promised("splatvol.workers()").as_u64() > Some(0),
        "no workers"
    );
    let first = browser.picture([240, 200]);
    assert!(
        opaque(&first) == expected,
        "the page's picture is not the command's"
    );
    let pose = browser.promised("splatvol.view()");

    browser.promised("splatvol.settled()");
    browser.drag("#view", [120, 40]);
    browser.promised("splatvol.settled()");
    assert_ne!(browser.promised("splatvol.view()"), pose);
    let turned = browser.picture([240, 200]);
    assert!(turned != first, "a drag turns nothing");
    browser.promised("document.getElementById('view').focus()");
    // Home.
    browser.press("\u{e011}");
    assert!(browser.picture([240, 200]) == first, "Home is not where it began");

    // By the panel: another range, then everything as it was.
    browser.promised(
        "(() => { const slider = document.querySelector('#controls input[type=range]'); \
         slider.value = Number(slider.min) + 0.6 * (slider.max - slider.min); \
         slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change')); })()",
    );
    browser.promised("splatvol.settled()");
    assert!(
        browser.picture([240, 200]) != first,
        "another range changes nothing"
    );
    browser.promised(
        "[...document.querySelectorAll('button')].find((made) => made.textContent === 'Undo').click()",
    );
    assert!(browser.picture([240, 200]) == first, "Undo leaves a trace");
    assert_eq!(
        browser.promised("document.getElementById('trouble').textContent"),
        ""
    );

    for url in browser.requests() {
        let own = url.ends_with("/head.html") && url.starts_with("file:");
        assert!(
            own || url.starts_with("blob:") || url.starts_with("data:"),
            "the page asks for {url}"
        );
    }
    // What asks all the same is stopped by the page's policy.
    let asked = browser.promised(
        "new Promise((done) => { document.addEventListener('securitypolicyviolation', () => done('refused')); \
         const image = document.createElement('img'); image.onload = () => done('read'); \
         image.src = 'https://192.0.2.1/'; document.body.append(image); })",
    );
    assert_eq!(asked, "refused");
}

#[test]
fn items_of_a_page_are_hidden_and_points_are_translucent() {
    in_browsers([500, 700], changes_items);
}

/// Items by their boxes, and the opacity of points by its slider: the pictures are those of documents that say so.
fn changes_items(browser: &Browser) {
    let sandbox = Sandbox::new();
    sandbox.write("ball.xyz", sphere(2000, [0.0; 3], Some([230, 60, 20])));
    sandbox.write("lone.ply", gaussian([0.9, 0.7, 0.1]));
    let view = "[camera]\nposition = [4, 3, 2]\ntarget = [0, 0, 0]\nfov = 40\n";
    let scene = |ball: &str, lone: &str| {
        format!("{view}[[item]]\nfile = \"ball.xyz\"\n{ball}[[item]]\nfile = \"lone.ply\"\n{lone}")
    };
    sandbox.write("both.toml", scene("", ""));
    sandbox.run("export both.toml --size 120 -o both.html").succeeds();
    browser.open(&sandbox.path("both.html"));
    let shows = |ball: &str, lone: &str| {
        sandbox.write("now.toml", scene(ball, lone));
        sandbox.run("render now.toml --size 120 -o now.png -w").succeeds();
        let shown = opaque(&browser.picture([120, 120]));
        assert!(shown == png(&sandbox.path("now.png")).2, "{ball} {lone}");
    };
    let check = |index: usize| {
        let click = format!("document.querySelectorAll('#controls input[type=checkbox]')[{index}].click()");
        browser.promised(&click);
    };
    let (hidden, faint) = ("visible = false\n", "opacity = 0.4\n");
    shows("", "");
    check(1);
    shows("", hidden);
    // The last one stays.
    check(0);
    shows("", hidden);
    assert_eq!(
        browser.promised("document.querySelector('#controls input[type=checkbox]').checked"),
        true
    );
    browser.promised(
        "(() => { const labels = [...document.querySelectorAll('#controls label')]; \
         const slider = document.getElementById(labels.find((made) => made.textContent === 'Opacity').htmlFor); \
         slider.value = 0.4; slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change')); })()",
    );
    shows(faint, hidden);
    check(1);
    shows(faint, "");
    let undo = "[...document.querySelectorAll('button')].find((made) => made.textContent === 'Undo').click()";
    for (ball, lone) in [(faint, hidden), ("", hidden), ("", "")] {
        browser.promised(undo);
        shows(ball, lone);
    }
    assert_eq!(
        browser.promised("document.getElementById('trouble').textContent"),
        ""
    );
}

#[test]
fn a_page_shows_where_workers_are_blocked() {
    in_browsers([420, 800], shows_without_workers);
}

fn shows_without_workers(browser: &Browser) {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:head:48 --size 160 -o head.png")
        .succeeds();
    sandbox.run("export --like head.png -o head.html").succeeds();
    let page = String::from_utf8(sandbox.bytes("head.html")).expect("a page is text");
    let blocked = page.replacen("worker-src blob:", "worker-src &#39;none&#39;", 1);
    assert_ne!(page, blocked);
    sandbox.write("blocked.html", blocked);
    browser.open(&sandbox.path("blocked.html"));
    assert_eq!(browser.promised("splatvol.workers()"), 0);
    assert!(opaque(&browser.picture([160, 160])) == png(&sandbox.path("head.png")).2);
    browser.promised("splatvol.settled()");
    assert_eq!(
        browser.promised("document.getElementById('trouble').textContent"),
        ""
    );
}

#[test]
fn twenty_scenes_are_the_commands_to_the_byte() {
    in_browsers([600, 500], shows_what_the_command_makes);
}

fn shows_what_the_command_makes(browser: &Browser) {
    let sandbox = Sandbox::new();
    sandbox.write(
        "two.toml",
        "[[item]]\nfile = \"sample:head:32\"\nopacity = \"linear\"\n[[item]]\nfile = \"sample:tomato:24\"\ntranslate = [90, 0, 0]\n",
    );
    sandbox.write(
        "regions.toml",
        "[[item]]\nfile = \"sample:head:40\"\n[[effects.regions]]\nvalue = [200, 2000]\ngradient = [20, 2000]\nrgb = [0.9, 0.8, 0.6]\nopacity = 0.6\n",
    );
    sandbox.write("ball.xyz", sphere(2000, [0.0; 3], Some([230, 60, 20])));
    sandbox.write("lone.ply", gaussian([0.9, 0.7, 0.1]));
    sandbox.write("bent.vtk", bent_block());
    sandbox.write(
        "all.toml",
        "[[item]]\nfile = \"ball.xyz\"\nradius = 0.06\n[[item]]\nfile = \"lone.ply\"\ntranslate = [0.4, -0.8, 1]\n\
         [[item]]\nfile = \"sample:head:32\"\nscale = 0.006\ntranslate = [1.5, 0, 0]\n\
         [[item]]\nfile = \"bent.vtk\"\nopacity = \"linear\"\ntranslate = [-2, 0, 0]\n",
    );
    let scenes = [
        "ball.xyz --point-color 0.2,0.8,0.3 --radius 0.1",
        "ball.xyz --compositing xray --background white",
        "lone.ply --up y --orthographic",
        "bent.vtk --cmap viridis --opacity linear",
        "all.toml",
        "all.toml --preset best",
        "all.toml --clip-plane 0,0,0.3:0,0,-1 --preset fast",
        "sample:head:48",
        "sample:head:48 --cmap viridis --opacity linear --background white",
        "sample:tomato:40 --preset fast --unit-distance 3",
        "sample:shells:40 --compositing mip --orthographic",
        "sample:nerve:32 --compositing xray --view top",
        "sample:head:40 --classification pre --no-shade",
        "sample:head:40 --clip-plane 0,0,20:0,0,-1 --coverage adaptive",
        "two.toml --preset fast",
        "regions.toml --preset fast",
        "sample:tomato:32 --preset best",
        "sample:head:40 --preset best",
        "sample:nerve:32 --preset best --orthographic --view top",
        "sample:shells:40 --gradient analytic --preset fast",
    ];
    for (index, scene) in scenes.into_iter().enumerate() {
        let page = format!("made-{index}.html");
        sandbox
            .run(&format!("render {scene} --size 150x110 -o made.png -w"))
            .succeeds();
        sandbox
            .run(&format!("export --like made.png -o {page}"))
            .succeeds();
        browser.open(&sandbox.path(&page));
        let picture = browser.picture([150, 110]);
        assert!(opaque(&picture) == png(&sandbox.path("made.png")).2, "{scene}");
    }
}

/// Where the browser has WebGPU, it draws what moves, within the GPU engine's laws; final pictures stay those of the processor.
#[test]
fn webgpu_draws_what_moves() {
    if !has_engine() {
        return;
    }
    if splatvol_page::webgpu().is_none() {
        splatvol_recorded::skip(
            "the GPU engine for browsers was not built of these sources (cargo xtask-webgpu --dev)",
        );
        return;
    }
    let _one = ONE.lock();
    let Some(browser) = Browser::start(Kind::ChromiumWithGpu, [500, 300]) else {
        return;
    };
    let sandbox = Sandbox::new();
    sandbox.write("ball.xyz", sphere(2000, [0.0; 3], Some([230, 60, 20])));
    sandbox.write("lone.ply", gaussian([0.9, 0.7, 0.1]));
    sandbox.write(
        "both.toml",
        "[[item]]\nfile = \"ball.xyz\"\nradius = 0.06\n[[item]]\nfile = \"sample:head:32\"\nscale = 0.006\ntranslate = [1.5, 0, 0]\n",
    );
    for (index, scene) in ["sample:head:32 --preset best", "lone.ply", "both.toml"]
        .into_iter()
        .enumerate()
    {
        let page = format!("gpu-{index}.html");
        sandbox
            .run(&format!(
                "export {scene} --background black --size 150x110 -o {page}"
            ))
            .succeeds();
        browser.open(&sandbox.path(&page));
        browser.promised("splatvol.settled()");
        // An edit before it joins, and one after.
        browser.promised("(document.querySelector('canvas').focus(), 0)");
        browser.press("]");
        browser.promised("splatvol.settled()");
        assert_eq!(browser.promised("splatvol.quicken()"), true, "{scene}");
        let sized = |what: &str| browser.pixels(&format!("splatvol.{what}(150, 110)"));
        let near = |step: &str| {
            let (draft, picture) = (sized("draft"), sized("picture"));
            let squares = draft
                .iter()
                .zip(&picture)
                .map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
            let mean = squares.sum::<f64>() / draft.len() as f64;
            let psnr = 20.0 * 255f64.log10() - 10.0 * mean.log10();
            assert!(psnr > 45.0, "{scene}, {step}: {psnr} dB");
            println!("{scene}, {step}: {psnr} dB");
            assert!(
                picture.chunks(4).any(|pixel| pixel[0] > 60),
                "{scene}: nothing is seen"
            );
            picture
        };
        let first = near("opened");
        browser.press("[");
        browser.press("\u{e012}");
        browser.promised("splatvol.settled()");
        assert!(near("turned") != first, "{scene}: nothing has turned");
        let badge = browser.promised("document.getElementById('badge').textContent");
        assert_eq!(badge, "final", "{scene}");
        let trouble = browser.promised("document.getElementById('trouble').textContent");
        assert_eq!(trouble, "", "{scene}");
    }
}

/// A bent block of 6 x 5 x 4 points with values, of VTK's legacy format.
pub(crate) fn bent_block() -> String {
    let places = (0..120).map(|i| [i % 6, i / 6 % 5, i / 30].map(|at| f64::from(at) * 0.3));
    let points: String = places
        .clone()
        .map(|[x, y, z]| format!("{} {y} {z}\n", x + 0.4 * y * z))
        .collect();
    let values: String = places
        .map(|[x, y, z]| format!("{}\n", (2.0 * x).sin() + y * z))
        .collect();
    format!(
        "# vtk DataFile Version 3.0\nbent\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 6 5 4\nPOINTS 120 float\n{points}\
         POINT_DATA 120\nSCALARS heat float 1\nLOOKUP_TABLE default\n{values}"
    )
}

/// RGB of opaque pixels.
pub(crate) fn opaque(pixels: &[u8]) -> Vec<u8> {
    assert!(
        pixels.chunks_exact(4).all(|pixel| pixel[3] == 255),
        "pixels are transparent"
    );
    pixels
        .chunks_exact(4)
        .flat_map(|pixel| pixel[..3].to_vec())
        .collect()
}
