//! Every option of decoding, seen from the statistics of maps whose normal is known by hand.

use crate::files;
use crate::workshop::Workshop;

/// The mean normal (s, t) of `image`, baked with `options`.
fn mean(workshop: &Workshop, image: &str, options: &[&str]) -> [f64; 2] {
    let bake = ["bake", image, "-o=map.glint", "--roughness=0.5"];
    workshop.succeeds(&[&bake, options].concat());
    let document = workshop.document(&["inspect", "map.glint", "--json"]);
    let mean = &document["metadata"]["statistics"]["mean"];
    [0, 1].map(|place| mean[place].as_f64().expect("a number"))
}

fn near(found: [f64; 2], expected: [f64; 2], what: &[&str]) {
    let far = (0..2).any(|place| (found[place] - expected[place]).abs() > 1e-6);
    assert!(!far, "{found:?} instead of {expected:?} for {what:?}");
}

/// (s, t, z) / length.
fn normalised([s, t, z]: [f64; 3]) -> [f64; 2] {
    let length = (s * s + t * t + z * z).sqrt();
    [s / length, t / length]
}

#[test]
fn each_option_moves_the_normals_as_its_help_says() {
    let workshop = Workshop::new();
    let unorm = |x: u8| f64::from(x) / 255.0 * 2.0 - 1.0;
    let (red, green, blue, alpha) = (160, 80, 220, 140);
    files::rgba8(&workshop.path("map.png"), (3, 2), |_, _| {
        [red, green, blue, alpha]
    });
    let full = normalised([red, green, blue].map(unorm));
    let centred = normalised([red, green, blue].map(|x| (f64::from(x) - 128.0) / 127.0));
    let cases: [(&[&str], [f64; 2]); 12] = [
        (&[], full),
        (&["--channels=xyz", "--y=gl", "--range=auto"], full),
        (&["--range=unorm", "--zero=127.5", "--wrap=repeat"], full),
        (&["--y=dx"], [full[0], -full[1]]),
        (&["--zero=128"], centred),
        (&["--zero=128", "--y=dx"], [centred[0], -centred[1]]),
        (&["--channels=xy"], [unorm(red), unorm(green)]),
        (&["--channels=rg"], [unorm(red), unorm(green)]),
        (&["--channels=ga"], [unorm(green), unorm(alpha)]),
        (&["--channels=ra"], [unorm(red), unorm(alpha)]),
        (&["--channels=ag"], [unorm(alpha), unorm(green)]),
        (&["--wrap=clamp"], full),
    ];
    for (options, expected) in cases {
        near(mean(&workshop, "map.png", options), expected, options);
    }
}

#[test]
fn wrap_is_kept_with_the_instance() {
    let workshop = Workshop::with_map();
    for wrap in ["repeat", "clamp"] {
        let option = format!("--wrap={wrap}");
        let said =
            workshop.succeeds(&["bake", "map.png", "-o=m.glint", "--roughness=0.1", &option]);
        let instance = said.lines().nth(1).unwrap_or_default();
        assert!(instance.ends_with(wrap), "{said}");
    }
}

#[test]
fn heights_become_slopes() {
    let workshop = Workshop::new();
    // Rises by 10 of 255 a texel to the right, and by 4 down.
    files::grey8(&workshop.path("bump.png"), (8, 6), |column, row| {
        (10 * column + 4 * row) as u8
    });
    let slope = |scale: f64| {
        let [right, down] = [10.0, 4.0].map(|step| step / 255.0 * scale);
        // Rows run against t: what rises downwards leans up.
        normalised([-right, down, 1.0])
    };
    let height = ["--input=height", "--wrap=clamp"];
    for (option, scale) in [
        ("--height-scale=1", 1.0),
        ("--height-scale=20", 20.0),
        ("--height-scale=-20", -20.0),
    ] {
        let options = [&height[..], &[option]].concat();
        near(
            mean(&workshop, "bump.png", &options),
            slope(scale),
            &options,
        );
    }
    near(mean(&workshop, "bump.png", &height), slope(1.0), &height);
}

#[test]
fn exr_layers_and_channels_are_chosen_by_name() {
    let workshop = Workshop::new();
    let texels = 6;
    let plane = |value: f32| vec![value; texels];
    files::exr(
        &workshop.path("map.exr"),
        (3, 2),
        &[
            (
                "beauty",
                &[("R", plane(0.1)), ("G", plane(0.2)), ("B", plane(1.0))],
            ),
            (
                "N",
                &[
                    ("W", plane(-0.4)),
                    ("X", plane(0.6)),
                    ("Y", plane(0.3)),
                    ("Z", plane(0.9)),
                ],
            ),
        ],
    );
    let (n, beauty) = ([0.6, 0.3, 0.9], [0.1, 0.2, 1.0]);
    let f32s = |values: [f64; 3]| values.map(|value| f64::from(value as f32));
    let cases: [(&[&str], [f64; 2]); 6] = [
        (&["--exr-layer=N"], normalised(f32s(n))),
        (&["--exr-layer=beauty"], normalised(f32s(beauty))),
        (&["--exr-layer=N", "--range=snorm"], normalised(f32s(n))),
        (
            &["--exr-layer=N", "--range=unorm"],
            normalised(f32s(n).map(|x| 2.0 * x - 1.0)),
        ),
        (
            &["--exr-layer=N", "--exr-channels=W,Y,Z"],
            normalised(f32s([-0.4, 0.3, 0.9])),
        ),
        (
            &["--exr-layer=N", "--exr-channels=W,X", "--channels=xy"],
            [f64::from(-0.4_f32), f64::from(0.6_f32)],
        ),
    ];
    for (options, expected) in cases {
        near(mean(&workshop, "map.exr", options), expected, options);
    }
}

#[test]
fn exr_layers_that_are_not_there_are_answered_with_those_that_are() {
    let workshop = Workshop::new();
    let plane = |value: f32| vec![value; 6];
    files::exr(
        &workshop.path("map.exr"),
        (3, 2),
        &[
            ("depth", &[("Z", plane(4.0))]),
            (
                "N",
                &[("X", plane(0.0)), ("Y", plane(0.0)), ("Z", plane(1.0))],
            ),
        ],
    );
    let bake = ["bake", "map.exr", "-o=map.glint", "--roughness=0.1"];
    workshop.refuses(
        2,
        &[&bake[..], &["--exr-layer=normals"]].concat(),
        &[
            "map.exr: ",
            "in layer normals",
            "the file holds ",
            "depth",
            "N",
        ],
    );
    workshop.refuses(
        2,
        &[&bake[..], &["--exr-channels=X,Y,Q"]].concat(),
        &["map.exr: ", "Q", "the file holds ", "X"],
    );
    workshop.succeeds(&[&bake[..], &["--exr-layer=N"]].concat());
    std::fs::remove_file(workshop.path("map.glint")).expect("the package");
    workshop.refuses(
        2,
        &[&bake[..], &["--zero=128"]].concat(),
        &["map.exr: ", "--zero 128"],
    );
}

#[test]
fn every_format_of_the_help_is_read() {
    let workshop = Workshop::new();
    let lossless = ["map.png", "map.tga", "map.tiff", "map.webp"];
    let mut means = Vec::new();
    for name in lossless {
        files::rgb8(&workshop.path(name), (24, 12), files::leaning);
        means.push(mean(&workshop, name, &["--force"]));
    }
    for pair in means.windows(2) {
        assert_eq!(pair[0], pair[1], "the same texels in {lossless:?}");
    }
    files::rgb8(&workshop.path("map.jpg"), (24, 12), |_, _| [140, 120, 250]);
    let found = mean(&workshop, "map.jpg", &["--repair"]);
    assert!(
        (found[0] - 0.0966).abs() < 0.02 && (found[1] + 0.058).abs() < 0.02,
        "JPEG is near: {found:?}"
    );
}
