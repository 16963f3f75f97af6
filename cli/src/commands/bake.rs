//! `bake`: image to package.

use super::{bake_material, describe, lattice, open, paths};
use crate::args::BakeArgs;
use crate::exit::{CommandError, Failure};
use crate::output::{Console, human_bytes};
use crate::picture::{ball, png};
use glintbake_bake::image::{HashedFile, InputFile};
use glintbake_bake::normals::{self, Statistics};
use glintbake_bake::package::publish;
use glintbake_bake::{PackagePlan, Progress, Source};
use glintbake_format::{HEADER_LENGTH, check};
use glintbake_runtime::{Material, Package, QueryError};
use serde_json::{Value, json};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Bakes the image, or the material if it is a material file, unless the package is there already with the same recipe and input.
///
/// # Errors
/// [`CommandError`] of the kind that names who can mend it; the old package, if any, is untouched.
pub fn run(arguments: &BakeArgs, console: &Console) -> Result<(), CommandError> {
    let optional = [
        ("--depfile", &arguments.depfile),
        ("--preview", &arguments.preview),
    ];
    let mut outputs = vec![("--output", arguments.output.as_path())];
    outputs.extend(
        optional
            .into_iter()
            .filter_map(|(option, path)| Some((option, path.as_deref()?))),
    );
    let baked = if arguments.is_material() {
        bake_material::bake(arguments, &outputs, console)?
    } else {
        bake_image(arguments, &outputs, console)?
    };
    if let Some(depfile) = &arguments.depfile {
        write_depfile(depfile, &arguments.output, &baked.inputs)?;
    }
    let bytes = open::bytes(&arguments.output, false)?;
    let package = open::package(&arguments.output, &bytes)?;
    let metadata = describe::metadata(&package)?;
    if !baked.up_to_date {
        for instance in package.instances() {
            // Of a material, what is said of the map stands with its layer.
            let of_layer = &metadata["material"][usize::from(instance.layer)];
            let (name, metadata) = match baked.maps.get(usize::from(instance.layer)) {
                Some(Some(map)) => (map.display(), of_layer),
                _ => (arguments.image.display(), &metadata),
            };
            lattice::warn(console, name, metadata, &instance);
        }
    }
    if let Some(preview) = &arguments.preview {
        let progress = console.progress("drawing the preview");
        let options = ball::Options::default();
        let picture = match Material::open(package.container()) {
            Ok(material) => ball::draw(&ball::Layered(material), &options)?,
            Err(QueryError::NotBaked { .. }) => {
                let first = package.instances().next().ok_or_else(|| {
                    CommandError::new(Failure::Internal, "the package has no instance")
                })?;
                ball::draw(&ball::Metal(package.ndf(first.number)?), &options)?
            }
            Err(error) => return Err(error.into()),
        };
        png::write_rgb8(preview, picture.side, picture.side, &picture.pixels)?;
        progress.finish_and_clear();
    }
    report(arguments, console, &package, &metadata, baked.up_to_date)
}

/// What a bake read, and whether it found nothing to do.
pub(super) struct Baked {
    /// Every file the package depends on.
    pub(super) inputs: Vec<PathBuf>,
    /// The map of each layer of a material.
    pub(super) maps: Vec<Option<PathBuf>>,
    /// Whether the package was there.
    pub(super) up_to_date: bool,
}

fn bake_image(
    arguments: &BakeArgs,
    outputs: &[(&str, &Path)],
    console: &Console,
) -> Result<Baked, CommandError> {
    let recipe = arguments.recipe()?;
    paths::check(Some(&arguments.image), outputs)?;
    let stages = console.stages();
    let file = HashedFile::open(&arguments.image, &stages)?;
    let input = file.identity();
    let up_to_date = !arguments.force && is_up_to_date(&arguments.output, recipe.hash(&[input]));
    if !up_to_date {
        let read_options = arguments.read_options(&recipe);
        let (map, statistics) = normals::read(&file, &read_options, &recipe.decode, &stages)
            .map_err(|error| with_folder(error.into(), input, &arguments.image))?;
        let source = Source {
            input: input.clone(),
            statistics,
        };
        let plan = glintbake_bake::bake_with_progress(&map, &recipe, Some(&source), &stages)?;
        drop(map);
        write(&arguments.output, &plan, &stages)?;
        stages.clear();
        warn(console, &source.statistics, &arguments.image);
    }
    stages.clear();
    Ok(Baked {
        inputs: [
            Some(arguments.image.clone()),
            arguments.ndf_maps.noise.clone(),
        ]
        .into_iter()
        .flatten()
        .collect(),
        maps: Vec::new(),
        up_to_date,
    })
}

/// Writes `plan` to the file at `path`, or leaves that as it was.
pub(super) fn write(
    path: &Path,
    plan: &PackagePlan,
    progress: &dyn Progress,
) -> Result<(), CommandError> {
    publish(path, |file| {
        // Sections are written in large pieces, so only the table and the padding gain from the buffer.
        let mut output = BufWriter::new(file);
        plan.write_with_progress(&mut output, progress)?;
        output.flush()
    })?;
    Ok(())
}

/// `error`, which names the input without its folder as packages do, naming it as the user did.
pub(super) fn with_folder(error: CommandError, input: &InputFile, path: &Path) -> CommandError {
    match error.message.strip_prefix(&format!("{}: ", input.name)) {
        Some(rest) => CommandError::new(error.failure, rest).in_file(path.display()),
        None => error,
    }
}

/// Whether the file at `path` is a whole package of the recipe and inputs that hash to `recipe`.
pub(super) fn is_up_to_date(path: &Path, recipe: [u8; 32]) -> bool {
    let Ok(bytes) = open::bytes(path, false) else {
        return false;
    };
    let Ok(package) = Package::open(&bytes) else {
        return false;
    };
    let container = package.container();
    let header = container.header();
    header.recipe_hash == recipe
        && bytes.len() > HEADER_LENGTH
        && check::content_hash(container) == header.content_hash
}

fn write_depfile(depfile: &Path, output: &Path, inputs: &[PathBuf]) -> Result<(), CommandError> {
    let mut rule = make_word(output);
    rule.push(b':');
    for input in inputs {
        rule.push(b' ');
        rule.extend(make_word(input));
    }
    rule.push(b'\n');
    publish(depfile, |file| file.write_all(&rule))?;
    Ok(())
}

/// `path` as make and ninja read a file name: blanks and the number sign behind a backslash, as is every backslash
/// right before them; the dollar doubled. All other bytes stand for themselves, Unicode or not.
fn make_word(path: &Path) -> Vec<u8> {
    let mut word = Vec::new();
    let mut backslashes = 0;
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b' ' | b'\t' | b'#' => word.extend(std::iter::repeat_n(b'\\', backslashes + 1)),
            b'$' => word.push(b'$'),
            _ => {}
        }
        backslashes = if byte == b'\\' { backslashes + 1 } else { 0 };
        word.push(byte);
    }
    word
}

/// Warns of texels of the map at `path` that were no normals.
pub(super) fn warn(console: &Console, statistics: &Statistics, path: &Path) {
    let name = path.display();
    if statistics.clamped_to_rim > 0 {
        console.warn(format_args!(
            "{name}: {} just outside the unit disk moved to its rim",
            texels(statistics.clamped_to_rim)
        ));
    }
    if statistics.repaired > 0 {
        console.warn(format_args!(
            "{name}: {} without a usable normal took the nearest valid one",
            texels(statistics.repaired)
        ));
    }
}

fn texels(count: u64) -> String {
    match count {
        1 => "1 texel".to_owned(),
        _ => format!("{count} texels"),
    }
}

fn report(
    arguments: &BakeArgs,
    console: &Console,
    package: &Package<'_>,
    metadata: &Value,
    up_to_date: bool,
) -> Result<(), CommandError> {
    let bytes = package.container().bytes().len() as u64;
    let per_texel = describe::bytes_per_texel(package, bytes);
    let path = arguments.output.display();
    let state = if up_to_date { " (up to date)" } else { "" };
    console.line(format_args!(
        "{path}: {}, {per_texel:.2} bytes a texel{state}",
        human_bytes(bytes)
    ));
    for instance in package.instances() {
        console.line(format_args!("  {}", describe::instance(&instance)));
    }
    for layer in describe::layers(package)? {
        console.line(format_args!("  {layer}"));
    }
    for line in describe::copies(metadata) {
        console.line(format_args!("  {line}"));
    }
    for line in describe::normals(metadata) {
        console.line(format_args!("  {line}"));
    }
    if let Some(preview) = &arguments.preview {
        console.line(format_args!("{}: preview", preview.display()));
    }
    console.document(&json!({
        "bytes": bytes,
        "bytes-per-texel": per_texel,
        "instances": package.instances().map(|instance| describe::instance_document(&instance)).collect::<Vec<_>>(),
        "layers": describe::layer_documents(package)?,
        "output": path.to_string(),
        "preview": arguments.preview.as_ref().map(|preview| preview.display().to_string()),
        "statistics": metadata["statistics"],
        "up-to-date": up_to_date,
    }));
    Ok(())
}
