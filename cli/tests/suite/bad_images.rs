//! Maps that cannot be baked: the code says whose fault it is, the message which file, texel and remedy.

use crate::files;
use crate::workshop::Workshop;
use std::fs;

/// A bake of `image` over an older `old.glint` must fail with `code`.
fn refuses(workshop: &Workshop, code: i32, image: &str, extra: &[&str], says: &[&str]) -> String {
    workshop.write("old.glint", "an older package, as far as anybody knows");
    let bake = [
        "bake",
        image,
        "-o=old.glint",
        "--roughness=0.1",
        "--depfile=d",
    ];
    let named = format!("{image}: ");
    let mut texts = vec![named.as_str()];
    texts.extend(says);
    workshop.refuses(code, &[&bake, extra].concat(), &texts)
}

#[test]
fn files_that_are_no_images() {
    let workshop = Workshop::new();
    refuses(
        &workshop,
        3,
        "none.png",
        &[],
        &["cannot be opened", "check the path"],
    );
    refuses(
        &workshop,
        3,
        "no/such/folder.png",
        &[],
        &["cannot be opened"],
    );
    fs::create_dir(workshop.path("folder.png")).expect("a folder");
    refuses(
        &workshop,
        3,
        "folder.png",
        &[],
        &["is a folder", "give the path of an image"],
    );
    workshop.write("empty.png", "");
    refuses(&workshop, 3, "empty.png", &[], &["is empty", "export"]);
    workshop.write("text.png", "just some words\n");
    refuses(
        &workshop,
        3,
        "text.png",
        &[],
        &["is not an image of any known format", "export"],
    );
    workshop.write("gif.png", b"GIF89a\x01\x00\x01\x00\x80\x00\x00");
    refuses(
        &workshop,
        3,
        "gif.png",
        &[],
        &["Gif", "export the map as PNG"],
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_or_a_device_is_refused_without_waiting_for_it() {
    let workshop = Workshop::new();
    let made = std::process::Command::new("mkfifo")
        .arg(workshop.path("pipe.png"))
        .status();
    if made.is_ok_and(|status| status.success()) {
        refuses(&workshop, 3, "pipe.png", &[], &["is a pipe or a device"]);
        workshop.refuses(3, &["inspect", "pipe.png"], &["pipe.png: ", "a pipe"]);
        workshop.refuses(3, &["verify", "pipe.png"], &["pipe.png: ", "a pipe"]);
    }
    refuses(&workshop, 3, "/dev/zero", &[], &["is a pipe or a device"]);
    workshop.refuses(3, &["inspect", "/dev/zero", "--no-mmap"], &["a device"]);
}

#[test]
fn a_png_cut_short_anywhere_is_refused() {
    let workshop = Workshop::with_map();
    let whole = workshop.read("map.png");
    let lengths = (1..60)
        .chain((60..whole.len()).step_by(whole.len() / 24))
        .chain(whole.len() - 14..whole.len());
    for length in lengths {
        workshop.write("cut.png", &whole[..length]);
        // Of less than the signature nobody can say what it was.
        let says: &[&str] = if length < 8 {
            &[]
        } else {
            &["cut off", "copy or export"]
        };
        refuses(&workshop, 3, "cut.png", &[], says);
    }
}

#[test]
fn a_png_with_flipped_bits_is_refused_or_baked_but_never_half() {
    let workshop = Workshop::with_map();
    let whole = workshop.read("map.png");
    for place in (0..whole.len()).step_by(whole.len() / 40) {
        let mut flipped = whole.clone();
        flipped[place] ^= 0x10;
        workshop.write("map.png", &flipped);
        fs::remove_file(workshop.path("new.glint")).ok();
        let run = workshop.run(&["bake", "map.png", "-o=new.glint", "--roughness=0.1"]);
        match run.code {
            Some(0) => {
                workshop.succeeds(&["verify", "new.glint"]);
            }
            _ => {
                assert!(matches!(run.code, Some(3 | 4)), "{run:#?}");
                run.error(run.code.expect("a code"), &["map.png: "]);
                assert!(!workshop.path("new.glint").exists());
            }
        }
    }
}

#[test]
fn a_png_that_claims_more_texels_than_any_memory_holds_is_refused_by_its_header() {
    let workshop = Workshop::with_map();
    let mut bytes = workshop.read("map.png");
    // Width and height lie at 16 and 20; the checksum behind them is not what must refuse this.
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    workshop.write("huge.png", &bytes);
    refuses(
        &workshop,
        3,
        "huge.png",
        &[],
        &[
            "2147483647 x 2147483647",
            "limit of 65535 x 65535",
            "cut it into tiles",
        ],
    );
}

#[test]
fn a_map_beyond_the_memory_limit_is_refused_before_it_is_read() {
    let workshop = Workshop::new();
    files::rgb8(&workshop.path("map.png"), (256, 200), files::leaning);
    // 51 200 texels: 20 bytes each with bins for one roughness, 32 for two, and with a tree whatever the number.
    let bake = ["bake", "map.png", "-o=map.glint"];
    for enough in [
        "--method=flake-bins --roughness=0.1 --memory=1.2MB",
        "--roughness=0.1 --memory=1.7MB",
        "--roughness=0.1,0.2,0.3 --memory=1.7MB",
    ] {
        let options: Vec<_> = enough.split(' ').collect();
        workshop.succeeds(&[&bake[..], &options].concat());
    }
    refuses(
        &workshop,
        3,
        "map.png",
        &["--method=flake-bins", "--roughness=0.2", "--memory=1.2MB"],
        &["256 x 200 texels", "37500", "--memory"],
    );
    for (method, texels) in [
        ("--method=flake-bins", "50000"),
        ("--method=cluster-tree", "31250"),
    ] {
        refuses(
            &workshop,
            3,
            "map.png",
            &[method, "--memory=1MB"],
            &[texels, "--memory"],
        );
    }
}

#[test]
fn nan_in_an_exr_is_named_by_its_texel() {
    let workshop = Workshop::new();
    let texels = 12;
    let mut s = vec![0.1; texels];
    s[6] = f32::NAN;
    s[9] = f32::INFINITY;
    let channels = [("X", s), ("Y", vec![0.0; texels]), ("Z", vec![1.0; texels])];
    files::exr(&workshop.path("map.exr"), (4, 3), &[("N", &channels)]);
    refuses(
        &workshop,
        4,
        "map.exr",
        &[],
        &["texel (2, 1)", "NaN", "1 more", "--repair"],
    );
    let run = workshop.run(&[
        "bake",
        "map.exr",
        "-o=map.glint",
        "--roughness=0.1",
        "--repair",
    ]);
    assert_eq!(run.code, Some(0), "{run:#?}");
    assert!(
        run.stderr
            .starts_with("warning: map.exr: 2 texels without a usable normal"),
        "{run:#?}"
    );
    workshop.succeeds(&["verify", "map.glint"]);
}

#[test]
fn normals_without_a_direction_are_refused_unless_repaired() {
    let workshop = Workshop::new();
    // With zero at 128, (128, 128, 128) is the zero vector.
    files::rgb8(&workshop.path("map.png"), (16, 16), |column, row| {
        if (column, row) == (5, 3) || row == 9 {
            [128, 128, 128]
        } else {
            files::leaning(column, row)
        }
    });
    refuses(
        &workshop,
        4,
        "map.png",
        &["--zero=128"],
        &["texel (5, 3) is (128, 128, 128)", "16 more", "--repair"],
    );
    let bake = [
        "bake",
        "map.png",
        "-o=map.glint",
        "--roughness=0.5",
        "--zero=128",
        "--repair",
    ];
    let run = workshop.run(&bake);
    assert_eq!(run.code, Some(0), "{run:#?}");
    assert_eq!(
        run.stderr,
        "warning: map.png: 17 texels without a usable normal took the nearest valid one\n"
    );
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    assert_eq!(document["metadata"]["statistics"]["repaired"], 17);
    assert_eq!(
        workshop.succeeds(&[&bake[..], &["--quiet", "--force"]].concat()),
        ""
    );
}

#[test]
fn a_map_is_named_by_the_path_it_was_given_by() {
    let workshop = Workshop::new();
    fs::create_dir(workshop.path("maps")).expect("a folder");
    files::rgb8(&workshop.path("maps/bad.png"), (8, 8), |_, _| [0, 0, 0]);
    refuses(
        &workshop,
        4,
        "maps/bad.png",
        &[],
        &["none of its 64 texels"],
    );
    refuses(
        &workshop,
        4,
        "./maps/bad.png",
        &["--channels=ga"],
        &["--channels ga"],
    );
    workshop.write("maps/text.png", "words");
    refuses(&workshop, 3, "maps/text.png", &[], &["not an image"]);
}

#[test]
fn a_map_without_one_valid_texel_is_not_repaired_but_questioned() {
    let workshop = Workshop::new();
    files::rgb8(&workshop.path("black.png"), (8, 8), |_, _| [0, 0, 0]);
    for extra in [&[][..], &["--repair"]] {
        refuses(
            &workshop,
            4,
            "black.png",
            extra,
            &["none of its 64 texels is valid", "--channels"],
        );
    }
}

#[test]
fn a_grey_map_is_asked_whether_it_holds_heights() {
    let workshop = Workshop::new();
    files::grey8(&workshop.path("bump.png"), (8, 8), |column, _| column as u8);
    refuses(
        &workshop,
        4,
        "bump.png",
        &[],
        &["one grey channel", "--input height"],
    );
    files::rgb8(&workshop.path("rgb.png"), (8, 8), files::leaning);
    refuses(
        &workshop,
        4,
        "rgb.png",
        &["--channels=ga"],
        &["no alpha channel", "--channels xyz"],
    );
}
