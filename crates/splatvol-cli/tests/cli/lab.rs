//! `splatvol lab`: the list, one experiment, what it leaves behind and what it refuses.

use crate::sandbox::Sandbox;

/// The shortest experiment.
const NAME: &str = "beyond-absorption";

#[test]
fn without_a_name_all_are_listed_with_their_figures() {
    let listed = Sandbox::new().run("lab").succeeds().stdout();
    for part in [
        "swan1997:",
        "mueller1998:",
        "huang2000:",
        "zwicker2001:",
        "beyond:",
        NAME,
        "Table 1",
        "Fig. 10",
    ] {
        assert!(listed.contains(part), "{part}\n{listed}");
    }
}

#[test]
fn an_experiment_leaves_pictures_plots_and_numbers() {
    let sandbox = Sandbox::new();
    let told = sandbox
        .run(&format!("lab {NAME} --quick -o out"))
        .succeeds()
        .stdout();
    assert!(
        told.starts_with(NAME) && told.contains("measured") && told.contains("condition"),
        "{told}"
    );
    let findings =
        String::from_utf8(sandbox.bytes(&format!("out/{NAME}/findings.csv"))).expect("CSV is text");
    assert!(
        findings.starts_with("figure,key,quantity,unit,published,measured"),
        "{findings}"
    );
    let files = std::fs::read_dir(sandbox.path(&format!("out/{NAME}"))).expect("the folder is there");
    let names: Vec<String> = files
        .map(|file| {
            file.expect("it can be read")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert!(names.iter().any(|name| name.ends_with(".svg")), "{names:?}");
    // Existing files are not overwritten without a request.
    sandbox
        .run(&format!("lab {NAME} --quick -o out"))
        .fails(5, &["exists"]);
    sandbox.run(&format!("lab {NAME} --quick -o out -w")).succeeds();
}

#[test]
fn a_report_is_one_page() {
    let sandbox = Sandbox::new();
    sandbox
        .run(&format!("lab {NAME} --quick --report out"))
        .succeeds();
    let page = String::from_utf8(sandbox.bytes("out/index.html")).expect("HTML is text");
    assert!(
        page.contains("<svg") && page.contains(NAME) && !page.contains("src=\"http"),
        "{}",
        page.len()
    );
    let text = String::from_utf8(sandbox.bytes("out/lab.md")).expect("Markdown is text");
    assert!(text.contains(&format!("### {NAME}")), "{text}");
    sandbox
        .run(&format!("lab {NAME} --quick --report out"))
        .fails(5, &["exists"]);
}

#[test]
fn data_that_are_needed_are_named() {
    let sandbox = Sandbox::new();
    let name = "swan1997-volcano";
    sandbox
        .run(&format!("lab {name} --quick"))
        .fails(3, &[name, "terrain/dem.csv is needed", "--data"]);
    sandbox.write("data/terrain/dem.csv", b"1 2\n3 4 5\n");
    sandbox.write("data/terrain/dem.jpg", b"");
    sandbox
        .run(&format!("lab {name} --quick --data data"))
        .fails(3, &[name, "dem.csv", "row 1"]);
    sandbox
        .run(&format!("lab {name} --quick --data nowhere"))
        .fails(3, &["--data nowhere", "no such folder"]);
    sandbox.run("lab --data data").fails(2, &["NAME"]);
}

#[test]
fn unknown_names_and_idle_flags_are_refused() {
    let sandbox = Sandbox::new();
    sandbox
        .run("lab swan1997-chequer")
        .fails(2, &["did you mean 'swan1997-checker'"]);
    sandbox.run("lab --quick").fails(2, &["NAME"]);
    assert!(sandbox.files().is_empty());
}
