//! Exit codes: one per kind of failure, so that scripts can tell who has to act.

use glintbake_bake::BakeError;
use glintbake_bake::image::ImageError;
use glintbake_bake::material::MaterialError;
use glintbake_bake::noise::NoiseError;
use glintbake_bake::normals::NormalsError;
use glintbake_bake::package::PublishError;
use glintbake_format::Finding;
use glintbake_runtime::QueryError;

/// Why a command failed. Its discriminant is the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Failure {
    /// 1: `verify` or `stress` found faults, or `report` something worse than `--fail-on` allows.
    Findings = 1,
    /// 2: an option or its value is wrong.
    Usage = 2,
    /// 3: an input file cannot be read, or is not of a readable kind.
    Input = 3,
    /// 4: an input was read, but its texels, rows or keys are not what they must be.
    Content = 4,
    /// 5: a package is damaged, of another version, or no package.
    Package = 5,
    /// 6: the package was baked without what the command asks for.
    NotBaked = 6,
    /// 7: an output cannot be written; an older file of its name is untouched.
    Output = 7,
    /// 70: a defect of glintbake itself.
    Internal = 70,
}

impl Failure {
    /// The exit code.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The word for JSON output.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Findings => "findings",
            Self::Usage => "usage",
            Self::Input => "input",
            Self::Content => "content",
            Self::Package => "package",
            Self::NotBaked => "not-baked",
            Self::Output => "output",
            Self::Internal => "internal",
        }
    }
}

/// The end of `--help`: every exit code.
pub const EXIT_CODES_HELP: &str = "\
Exit codes:
   0  success
   1  verify or stress found faults, or report something worse than --fail-on allows
   2  an option or its value is wrong
   3  an input file cannot be read, or is not of a readable kind
   4  an input was read, but its texels, rows or keys are not what they must be
   5  a package is damaged, of another version, or no package
   6  the package was baked without what the command asks for
   7  an output cannot be written; an older file of its name is untouched
  70  a defect of glintbake itself";

/// A failure with the sentence a user reads.
#[derive(Debug)]
pub struct CommandError {
    /// Kind, and so exit code.
    pub failure: Failure,
    /// What failed, in which file, why, and what to do.
    pub message: String,
}

impl CommandError {
    /// A failure of kind `failure` that says `message`.
    pub fn new(failure: Failure, message: impl Into<String>) -> Self {
        Self {
            failure,
            message: message.into(),
        }
    }

    /// The same failure, its sentence begun with the file `name` it is about.
    #[must_use]
    pub fn in_file(mut self, name: impl std::fmt::Display) -> Self {
        self.message = format!("{name}: {}", self.message);
        self
    }
}

impl From<BakeError> for CommandError {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Option {
                option,
                value,
                reason,
            } if value.is_empty() => Self::new(Failure::Usage, format!("{option}: {reason}")),
            BakeError::Image(error) => error.into(),
            BakeError::Noise(error) => error.into(),
            BakeError::Normals(error) => error.into(),
            BakeError::Publish(error) => error.into(),
            BakeError::Material(error) => (*error).into(),
            BakeError::Option { .. } => Self::new(Failure::Usage, error.to_string()),
            BakeError::MapTooLarge { .. } => Self::new(Failure::Content, error.to_string()),
        }
    }
}

impl From<ImageError> for CommandError {
    fn from(error: ImageError) -> Self {
        let failure = match error {
            // The file is fine; it has no layer or channel of the name that was given.
            ImageError::Selection { .. } => Failure::Usage,
            _ => Failure::Input,
        };
        Self::new(failure, error.to_string())
    }
}

impl From<NoiseError> for CommandError {
    fn from(error: NoiseError) -> Self {
        let failure = match error {
            NoiseError::Image(error) => return error.into(),
            NoiseError::Layout { .. } | NoiseError::Pixel { .. } => Failure::Content,
            NoiseError::Option { .. } => Failure::Usage,
        };
        Self::new(failure, error.to_string())
    }
}

impl From<NormalsError> for CommandError {
    fn from(error: NormalsError) -> Self {
        let failure = match error {
            NormalsError::Option { .. } => Failure::Usage,
            _ => Failure::Content,
        };
        Self::new(failure, error.to_string())
    }
}

impl From<MaterialError> for CommandError {
    fn from(error: MaterialError) -> Self {
        let failure = match error {
            MaterialError::Open { .. } => Failure::Input,
            MaterialError::Syntax { .. }
            | MaterialError::Key { .. }
            | MaterialError::Count { .. }
            | MaterialError::Opacity { .. } => Failure::Content,
        };
        Self::new(failure, error.to_string())
    }
}

impl From<PublishError> for CommandError {
    fn from(error: PublishError) -> Self {
        Self::new(Failure::Output, error.to_string())
    }
}

impl From<Finding> for CommandError {
    fn from(finding: Finding) -> Self {
        Self::new(Failure::Package, finding.to_string())
    }
}

impl From<QueryError> for CommandError {
    fn from(error: QueryError) -> Self {
        let failure = match error {
            QueryError::NotFinite
            | QueryError::FootprintTooLarge
            | QueryError::TooManyTexels { .. } => Failure::Content,
            QueryError::SettingUnsupported(_)
            | QueryError::NotBaked { .. }
            | QueryError::NoSuchInstance(_) => Failure::NotBaked,
            QueryError::KernelUnsupported(_)
            | QueryError::FilterUnsupported(_)
            | QueryError::BoxesOnly(_)
            | QueryError::RoughnessRange { .. } => Failure::Usage,
            QueryError::Damaged(_) => Failure::Package,
        };
        Self::new(failure, error.to_string())
    }
}
