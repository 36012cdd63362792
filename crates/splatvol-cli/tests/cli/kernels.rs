//! `splatvol info --kernel` and the kernel flags of `render`, end to end.

use crate::sandbox::Sandbox;

fn info(sandbox: &Sandbox, arguments: &str) -> serde_json::Value {
    let text = sandbox
        .run(&format!("info {arguments} --json"))
        .succeeds()
        .stdout();
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn info_describes_kernels() {
    let sandbox = Sandbox::new();
    for (arguments, support, ripple) in [
        (
            "--kernel gaussian --kernel-sigma 0.602 --kernel-radius 2",
            2.0,
            0.01..0.0115,
        ),
        ("--kernel-sigma 1 --kernel-radius 2", 2.0, 0.13..0.15),
        ("--kernel crawfis-max", 1.556_228, 0.0074..0.0078),
        ("--kernel cubic-bspline", 2.0, 0.0035..0.0039),
        ("--kernel kaiser-bessel", 2.0, 1e-4..0.001),
        (
            "--kernel kaiser-bessel --kernel-radius 1.5 --kernel-alpha 3",
            1.5,
            0.149..0.154,
        ),
    ] {
        let report = info(&sandbox, arguments);
        assert_eq!(report["support"], support, "{arguments}");
        let found = report["ripple"].as_f64().unwrap();
        assert!(ripple.contains(&found), "{arguments}: {found}");
        assert!((report["mean"].as_f64().unwrap() - 1.0).abs() < 2e-3, "{report}");
        let response = report["response"].as_array().unwrap();
        assert_eq!(response.len(), 5);
        assert_eq!(
            (&response[0]["value"], &response[2]["frequency"]),
            (&1.0.into(), &0.5.into())
        );
    }
    let text = sandbox
        .run("info --kernel kaiser-bessel --bins 8")
        .succeeds()
        .stdout();
    for words in [
        "kaiser-bessel (radius 2, alpha 10.4443)",
        "ripple",
        "frequency response",
        "0.25",
        "1.75  ",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
}

#[test]
fn flags_without_meaning_are_refused() {
    let sandbox = Sandbox::new();
    for (arguments, words) in [
        (
            "--kernel crawfis-max --kernel-radius 2",
            ["--kernel-radius", "crawfis-max kernel, whose shape is fixed"],
        ),
        (
            "--kernel cubic-bspline --kernel-alpha 2",
            ["--kernel-alpha", "cubic-bspline"],
        ),
        (
            "--kernel kaiser-bessel --kernel-sigma 1",
            ["--kernel-sigma", "--kernel-alpha"],
        ),
        (
            "--kernel gaussian --kernel-alpha 1",
            ["--kernel-alpha", "--kernel-sigma"],
        ),
        (
            "--kernel kaiser-bessel --kernel-radius 9",
            ["kernel radius", "1 to 4 voxels"],
        ),
        ("--kernel box", ["box", "crawfis-max"]),
    ] {
        sandbox.run(&format!("info {arguments}")).fails(2, &words);
        sandbox
            .run(&format!("render sample:ball:8 --size 8 {arguments}"))
            .fails(2, &words);
    }
    sandbox.run("info").fails(2, &["INPUT"]);
    sandbox
        .run("info sample:ball --kernel gaussian")
        .fails(2, &["--kernel"]);
}

#[test]
fn a_kernel_that_is_no_gaussian_is_not_prefiltered() {
    let sandbox = Sandbox::new();
    sandbox
        .run("render sample:ball:8 --size 8 --kernel crawfis-max --prefilter")
        .fails(2, &["crawfis-max"]);
    sandbox
        .run("render sample:ball:8 --size 8 --kernel gaussian --kernel-sigma 0.7 -o a.png")
        .succeeds();
}
