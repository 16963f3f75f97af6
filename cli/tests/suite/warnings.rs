//! What a bake warns of: maps that are readable and still not what they should be.

use crate::files;
use crate::workshop::Workshop;

#[test]
fn eight_bits_are_too_few_for_a_small_roughness_and_the_user_is_told_so() {
    let workshop = Workshop::new();
    let sample = |bits: &str, name: &str| {
        workshop.succeeds(&["sample", "waves", "--size=48", "--bits", bits, "-o", name]);
    };
    sample("8", "eight.png");
    sample("16", "sixteen.png");
    let bake = |image: &str, extra: &[&str]| {
        let bake = ["bake", image, "-o=map.glint", "--force"];
        let run = workshop.run(&[&bake, extra].concat());
        assert_eq!(run.code, Some(0), "{run:#?}");
        run.stderr
    };
    let bins = "--method=flake-bins";
    let warning = bake("eight.png", &[bins, "--roughness=0.005"]);
    assert_eq!(warning.lines().count(), 1, "{warning}");
    for text in [
        "warning: eight.png: ",
        "lattice of step 0.00784",
        "roughness 0.005 (0.00424)",
        "glints will line up in rows",
        "Use a 16-bit or float map, or a roughness of 0.01 or more",
    ] {
        assert!(warning.contains(text), "{text:?} in {warning}");
    }
    let both = bake("eight.png", &[bins, "--roughness=0.005,0.002,0.05"]);
    assert_eq!(
        both.lines().count(),
        2,
        "one for each roughness that is too small: {both}"
    );
    assert_eq!(
        bake("eight.png", &[bins, "--roughness=0.01"]),
        "",
        "the remedy must help"
    );
    assert_eq!(bake("eight.png", &["--method=specular-bins"]), "");
    assert_eq!(
        bake("eight.png", &[bins, "--roughness=0.005", "--quiet"]),
        ""
    );
    assert_eq!(
        bake("sixteen.png", &[bins, "--roughness=0.005"]),
        "",
        "the remedy must help"
    );
}

#[test]
fn a_tree_is_warned_of_by_whoever_names_the_roughness() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=48", "--bits=8", "-o=map.png"]);
    workshop.write(
        "q.csv",
        "u,v,e1u,e1v,e2u,e2v,s,t\n0.5,0.5,0.1,0,0,0.1,0,0\n",
    );
    let warning = |arguments: &[&str]| {
        let run = workshop.run(arguments);
        assert_eq!(run.code, Some(0), "{run:#?}");
        run.stderr
    };
    let bake = ["bake", "map.png", "-o=map.glint", "--force"];
    assert_eq!(warning(&bake), "", "the default must be wide enough");
    let readers: [&[&str]; 3] = [
        &["query", "map.glint", "--queries=q.csv"],
        &["picture", "ndf", "map.glint", "-o=a.png", "--pixels=4"],
        &["picture", "ball", "map.glint", "-o=a.png", "--pixels=4"],
    ];
    for reader in readers {
        let with = |option| warning(&[reader, &[option]].concat());
        let said = with("--roughness=0.003");
        assert_eq!(said.lines().count(), 1, "{said}");
        for text in [
            "warning: map.glint: its normals lie on a lattice of step 0.00784",
            "coarser than flakes of roughness 0.003 bridge (0.00530)",
            "a roughness of 0.01 or more",
        ] {
            assert!(said.contains(text), "{text:?} in {said}");
        }
        assert_eq!(with("--roughness=0.01"), "", "the remedy must help");
        assert_eq!(with("--quiet"), "");
    }
    let baked = warning(&[&bake[..], &["--roughness=0.003,0.1"]].concat());
    assert!(
        baked.starts_with("warning: map.png: its normals"),
        "{baked}"
    );
    assert_eq!(baked.lines().count(), 1, "{baked}");
    assert_eq!(warning(readers[0]), "", "told at the bake already");
}

#[test]
fn sixteen_bits_that_hold_eight_are_told_apart() {
    let workshop = Workshop::new();
    files::rgb16(&workshop.path("map.png"), (24, 12), |column, row| {
        files::leaning(column, row).map(|x| u16::from(x) * 257)
    });
    let run = workshop.run(&["bake", "map.png", "-o=map.glint", "--roughness=0.003"]);
    assert!(run.stderr.contains("lattice of step 0.00784"), "{run:#?}");
}

#[test]
fn texels_just_outside_the_disk_are_counted() {
    let workshop = Workshop::new();
    // (255, 130) as s and t is one step outside of the unit disk.
    files::rgb8(&workshop.path("map.png"), (6, 4), |column, _| {
        if column == 2 {
            [255, 133, 0]
        } else {
            [140, 120, 0]
        }
    });
    let run = workshop.run(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--roughness=0.5",
        "--channels=xy",
    ]);
    assert_eq!(run.code, Some(0), "{run:#?}");
    assert_eq!(
        run.stderr,
        "warning: map.png: 4 texels just outside the unit disk moved to its rim\n"
    );
}

#[test]
fn warnings_leave_json_on_standard_output_alone() {
    let workshop = Workshop::new();
    workshop.succeeds(&["sample", "waves", "--size=48", "--bits=8", "-o=map.png"]);
    let run = workshop.run(&[
        "bake",
        "map.png",
        "-o=map.glint",
        "--roughness=0.003",
        "--json",
    ]);
    assert!(run.stderr.starts_with("warning: "), "{run:#?}");
    assert!(
        serde_json::from_str::<serde_json::Value>(&run.stdout).is_ok(),
        "{run:#?}"
    );
}
