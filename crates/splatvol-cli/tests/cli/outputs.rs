//! Where results go: what is never replaced, what cannot be written, and what is left behind then.

use crate::sandbox::Sandbox;

const RENDER: &str = "render sample:ball:24 --size 8x8";

#[test]
fn results_never_share_a_file() {
    let sandbox = Sandbox::new();
    for (flags, words) in [
        ("-o a.png --depth a.png", ["picture", "depth"]),
        ("-o a.png --stats ./a.png", ["picture", "statistics"]),
        ("-o a.png --depth b.npy --stats b.npy", ["depth", "statistics"]),
        ("-o - --stats -", ["picture", "statistics"]),
    ] {
        sandbox.run(&format!("{RENDER} {flags} -w")).fails(2, &words);
    }
    for movie in ["a.gif", "a-##.png"] {
        let name = movie.replace("##", "01");
        sandbox
            .run(&format!(
                "animate sample:ball:24 --size 8x8 --frames 2 -o {movie} --stats {name}"
            ))
            .fails(2, &["animation", "statistics", &name]);
    }
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}

#[test]
fn an_animation_refuses_depths_and_lists_methods() {
    let sandbox = Sandbox::new();
    let animate = "animate sample:ball:24 --size 8x8 --frames 2 -o a.gif";
    sandbox
        .run(&format!("{animate} --depth d.exr"))
        .fails(2, &["--depth"]);
    let listed = sandbox.run("animate --list-methods").succeeds().stdout();
    assert_eq!(listed, sandbox.run("render --list-methods").succeeds().stdout());
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}

#[test]
fn pictures_between_sheets_lie_beside_the_picture() {
    let sandbox = Sandbox::new();
    let papers = format!("{RENDER} --preset fastsplats2000 --no-metadata");
    sandbox.run(&format!("{papers} -o a.png --partial 9")).succeeds();
    let files = sandbox.files();
    let between: Vec<_> = files.iter().filter(|name| *name != "a.png").collect();
    assert!(
        between.len() > 2 && files.contains(&"a.0009.png".to_owned()),
        "{files:?}"
    );
    let last = between.iter().max().unwrap();
    assert_eq!(sandbox.bytes(last), sandbox.bytes("a.png"));
    assert_ne!(sandbox.bytes("a.0009.png"), sandbox.bytes("a.png"));
    sandbox
        .run(&format!("{papers} -o - --partial 9"))
        .fails(2, &["--partial", "-o FILE"]);
    sandbox
        .run(&format!("{RENDER} -o b.png --partial 9"))
        .fails(4, &["partial", "fastsplats2000"]);
    sandbox
        .run(&format!("{RENDER} -o b.png --partial 0"))
        .fails(2, &["--partial"]);
    assert!(!sandbox.files().contains(&"b.png".to_owned()));
}

#[test]
fn too_many_threads_are_capped_with_a_warning() {
    let sandbox = Sandbox::new();
    let run = sandbox
        .run(&format!("{RENDER} -o a.png --threads 100000"))
        .succeeds();
    let text = run.stderr();
    assert!(text.contains("warning: --threads 100000"), "{text}");
    sandbox.run(&format!("{RENDER} -o b.png --threads 1")).succeeds();
    assert!(sandbox.bytes("a.png").len() > 64);
}

#[test]
fn a_picture_without_metadata_says_nothing() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&format!("{RENDER} -o a.png --no-metadata"))
        .succeeds();
    assert!(!String::from_utf8_lossy(&sandbox.bytes("a.png")).contains("splatvol"));
    sandbox
        .run("render --like a.png -o b.png")
        .fails(3, &["does not say how"]);
}

#[test]
fn absolute_paths_do_not_get_into_pictures() {
    let sandbox = Sandbox::new();
    sandbox.write("in/empty.txt", "");
    sandbox.run("sample ball --size 8 -o in/ball.nrrd").succeeds();
    let folder = sandbox.path("");
    let folder = folder.display().to_string();
    let folder = folder.trim_end_matches('/');
    sandbox
        .run(&format!(
            "render {folder}/in/ball.nrrd --size 8x8 -o {folder}/a.png"
        ))
        .succeeds();
    let text = String::from_utf8_lossy(&sandbox.bytes("a.png")).into_owned();
    assert!(text.contains("in/ball.nrrd") && !text.contains(folder), "{text}");
    sandbox.run("render --like a.png -o b.png").succeeds();
    assert_eq!(sandbox.bytes("a.png"), sandbox.bytes("b.png"));
}

#[test]
fn a_picture_names_files_beside_it_or_here_unless_more_is_allowed() {
    let sandbox = Sandbox::new();
    sandbox.run("sample ball --size 8 -o ball.nrrd").succeeds();
    sandbox.write("in/empty.txt", "");
    let inside = sandbox.below("in");
    inside.run("render ../ball.nrrd --size 8x8 -o a.png").succeeds();
    inside
        .run("render --like a.png -o b.png")
        .fails(3, &["../ball.nrrd", "outside", "--allow-outside"]);
    inside
        .run("render --like a.png -o b.png --allow-outside")
        .succeeds();
    inside.run("render --like a.png ../ball.nrrd -o c.png").succeeds();
}

#[test]
fn more_samples_than_are_allowed_are_refused_by_name() {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:ball:8 --max-memory much -o a.png")
        .fails(2, &["500M"]);
    sandbox.run("sample ball --size 64 -o ball.nrrd").succeeds();
    sandbox
        .run("render ball.nrrd --max-memory 1K --size 8x8 -o a.png")
        .fails(3, &["bytes are needed", "--max-memory"]);
    sandbox
        .run("render ball.nrrd --max-memory 1G --size 8x8 -o a.png")
        .succeeds();
}

#[cfg(unix)]
mod unix {
    use std::fs::File;
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::process::{Command, Stdio};

    use super::*;

    #[test]
    fn pipes_sockets_and_devices_are_never_replaced() {
        let sandbox = Sandbox::new();
        let pipe = sandbox.path("pipe.png");
        let made = Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .expect("mkfifo is there");
        assert!(made.success());
        let socket = sandbox.path("socket.png");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("sockets can be made");
        for name in ["pipe.png", "socket.png"] {
            sandbox
                .run(&format!("{RENDER} -o {name} -w"))
                .fails(5, &[name, "neither a regular file nor a new one"]);
            sandbox
                .run(&format!("{RENDER} -o a.png --stats {name} -w"))
                .fails(5, &[name]);
        }
        // The null device: a test that fails here must not replace one that the machine needs.
        sandbox
            .run(&format!("{RENDER} -o a.png --stats /dev/null"))
            .fails(5, &["/dev/null"]);
        let kind = std::fs::symlink_metadata(&pipe)
            .expect("the pipe is there")
            .file_type();
        assert!(kind.is_fifo());
        let kind = std::fs::symlink_metadata(&socket)
            .expect("the socket is there")
            .file_type();
        assert!(kind.is_socket());
    }

    #[test]
    fn the_file_that_a_link_leads_to_is_replaced_and_the_link_stays() {
        let sandbox = Sandbox::new();
        sandbox.write("elsewhere/a.png", "old");
        symlink("elsewhere/a.png", sandbox.path("link.png")).expect("links can be made");
        sandbox
            .run(&format!("{RENDER} -o link.png"))
            .fails(5, &["already exists"]);
        sandbox
            .run(&format!("{RENDER} -o link.png --stats elsewhere/a.png -w"))
            .fails(2, &["same file"]);
        sandbox.run(&format!("{RENDER} -o link.png -w")).succeeds();
        assert!(sandbox.bytes("elsewhere/a.png").starts_with(b"\x89PNG"));
        let link = std::fs::symlink_metadata(sandbox.path("link.png")).expect("the link is there");
        assert!(link.is_symlink());
        symlink("nowhere.png", sandbox.path("dangling.png")).expect("links can be made");
        sandbox
            .run(&format!("{RENDER} -o dangling.png -w"))
            .fails(5, &["a link that leads nowhere"]);
    }

    #[test]
    fn pictures_that_the_memory_does_not_hold_are_refused_by_name() {
        let script = format!(
            "ulimit -v 4000000; exec {} render sample:ball:8 --size 20000x20000 -o -",
            env!("CARGO_BIN_EXE_splatvol")
        );
        let output = Command::new("sh").args(["-c", &script]).output();
        let output = output.expect("there is a shell");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(
            text.contains("--size 20000x20000") && text.contains("MiB"),
            "{text}"
        );
    }

    #[test]
    fn links_that_lead_out_of_an_input_are_followed_only_on_request() {
        let sandbox = Sandbox::new();
        sandbox.write("elsewhere/empty.txt", "");
        sandbox
            .run("sample ball --size 8 -o elsewhere/ball.nrrd")
            .succeeds();
        let text = sandbox.bytes("elsewhere/ball.nrrd");
        let end = text
            .windows(2)
            .position(|pair| pair == b"\n\n")
            .expect("a header ends")
            + 1;
        sandbox.write("data/ball.raw", &text[end + 1..]);
        let header = String::from_utf8_lossy(&text[..end]).into_owned();
        sandbox.write("in/ball.nhdr", format!("{header}data file: ball.raw\n"));
        symlink("../data/ball.raw", sandbox.path("in/ball.raw")).expect("links can be made");
        sandbox
            .run("info in/ball.nhdr")
            .fails(3, &["leads out of its folder", "--allow-outside"]);
        sandbox.run("info in/ball.nhdr --allow-outside").succeeds();
    }

    /// Exit code of a command whose stderr is a full disk.
    #[cfg(target_os = "linux")]
    fn code_with_full_stderr(arguments: &str) -> Option<i32> {
        let full = File::options()
            .write(true)
            .open("/dev/full")
            .expect("Linux has it");
        let status = Command::new(env!("CARGO_BIN_EXE_splatvol"))
            .args(arguments.split_whitespace())
            .stdout(Stdio::null())
            .stderr(full)
            .status();
        status.expect("the command was built").code()
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn exit_codes_are_the_documented_ones_where_nothing_can_be_said() {
        let sandbox = Sandbox::new();
        let picture = sandbox.path("a.png");
        let picture = picture.display();
        assert_eq!(
            code_with_full_stderr(&format!("{RENDER} -o {picture} --verbose")),
            Some(0)
        );
        assert_eq!(code_with_full_stderr("info nowhere.nrrd"), Some(3));
        assert_eq!(code_with_full_stderr("info --no-such-flag"), Some(2));
        let full = File::options()
            .write(true)
            .open("/dev/full")
            .expect("Linux has it");
        let status = Command::new(env!("CARGO_BIN_EXE_splatvol"))
            .args(["info", "sample:ball:8"])
            .stdout(full)
            .stderr(Stdio::null())
            .status();
        assert_eq!(status.expect("the command was built").code(), Some(5));
    }
}

/// Pictures that take more than half of `--memory` are made in bands of rows; these take three.
#[test]
fn bands_of_rows_make_the_bytes_of_the_whole_picture() {
    let sandbox = Sandbox::new();
    let view = "--size 260x300 --no-metadata -w";
    for flags in [
        "sample:head:40",
        "sample:head:40 --preset fast --background none",
        "sample:head:40 --compositing xray --background white --bits 16",
        "sample:head:40 --coverage adaptive --spin 20 --motion-blur subframes --subframes 3",
        "sample:head:40 --compositing per-splat --classification pre",
    ] {
        sandbox
            .run(&format!("render {flags} {view} -o whole.png"))
            .succeeds();
        sandbox
            .run(&format!(
                "render {flags} {view} --memory 26M --stats s.json -o bands.png"
            ))
            .succeeds();
        assert!(
            sandbox.bytes("whole.png") == sandbox.bytes("bands.png"),
            "{flags}"
        );
        let statistics: serde_json::Value = serde_json::from_slice(&sandbox.bytes("s.json")).unwrap();
        assert!(statistics["seconds"]["total"].as_f64().unwrap() > 0.0);
    }
    // What cannot be made in bands is made as a whole, where there is memory.
    sandbox
        .run(&format!(
            "render sample:head:40 {view} --memory 26M --depth d.npy -o whole.exr"
        ))
        .succeeds();
    sandbox
        .run("render sample:head:40 --preset fast --size 32768x32768 --depth d.npy -w -o a.png")
        .fails(2, &["32768x32768", "MiB", "in bands of rows"]);
}
