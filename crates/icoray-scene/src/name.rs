//! File names from a template: MPAS's `$Y-$M-$D_$h.$m.$s`, and `{step:06}`, `{field}`.

use super::template::{Template, name_part};
use icoray_grid::{Error, ErrorKind, Result};

/// When a frame was: the model's step, its time, and its date where it has one.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stamp {
    /// Step number of the model.
    pub step: i64,
    /// Model time in seconds since its start.
    pub time_s: f64,
    /// Date and time, `YYYY-MM-DD_hh:mm:ss` or with a T between (the year may have more digits).
    pub date: Option<String>,
}

/// A checked template for picture names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NameTemplate(Template);

impl NameTemplate {
    /// Parses `template`: `{step}`, `{step:06}` (zero-padded to 6), `{when}` (date and step, or the step where there is
    /// no date), `{field}`, `$Y $M $D $h $m $s`, and `{view}`, `{lon}`, `{lat}`, `{distance}`, `{exaggeration}`,
    /// which a [`Script`](crate::script::Script) has values for. It ends in `.png` or `.exr`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] names the part that is not understood.
    pub fn new(template: &str) -> Result<Self> {
        if !(template.ends_with(".png") || template.ends_with(".exr")) {
            let context = format!("{template:?}: expected a name that ends in .png or .exr");
            return Err(Error::new(ErrorKind::Scene, context));
        }
        Template::new(template, &Template::WORDS).map(NameTemplate)
    }

    /// The name of a frame.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] when the template has a date and `stamp` has none, or one that is not understood;
    /// [`ErrorKind::Scene`] when it has a word that no script has filled in.
    pub fn name(&self, stamp: &Stamp, field: &str) -> Result<String> {
        if let Some(word) = self.0.words().find(|word| *word != "field") {
            let context = format!("{{{word}}} in a picture's name, and nothing of that name is drawn in turn");
            return Err(Error::new(ErrorKind::Scene, context));
        }
        self.0.fill(stamp, |_| name_part(field))
    }

    /// With these values for words.
    #[must_use]
    pub(crate) fn with(&self, values: &[(&'static str, String)]) -> Self {
        NameTemplate(self.0.with(values))
    }

    pub(crate) fn template(&self) -> &Template {
        &self.0
    }
}

/// How the files of a frame are named.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// The picture.
    pub file: NameTemplate,
    /// The map of its errors, a PNG; `None` writes none.
    pub error: Option<NameTemplate>,
    /// Index files beside the pictures.
    pub series: Series,
}

/// The names of one frame's files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameNames {
    /// The picture.
    pub file: String,
    /// The map of its errors.
    pub error: Option<String>,
}

impl From<NameTemplate> for Output {
    /// A picture alone.
    fn from(file: NameTemplate) -> Self {
        Output { file, error: None, series: Series::default() }
    }
}

impl Output {
    /// The names of a frame's files; those of a Cinema database lie in its folder.
    ///
    /// # Errors
    /// As [`NameTemplate::name`]; [`ErrorKind::Scene`] when both files would have the same name.
    pub fn names(&self, stamp: &Stamp, field: &str) -> Result<FrameNames> {
        let names = self.names_of_any(stamp, field)?;
        if names.error.as_ref() == Some(&names.file) {
            let what = "output.file and output.error both name it, expected two names";
            return Err(Error::new(ErrorKind::Scene, format!("{:?}: {what}", names.file)));
        }
        Ok(names)
    }

    /// The names of a frame that stands for others: it does not matter whether both are the same at its step.
    ///
    /// # Errors
    /// As [`NameTemplate::name`].
    pub fn names_of_any(&self, stamp: &Stamp, field: &str) -> Result<FrameNames> {
        let file = self.file.name(stamp, field)?;
        let error = self.error.as_ref().map(|error| error.name(stamp, field)).transpose()?;
        let within = |name: String| match &self.series.cinema {
            Some(Cinema { folder, .. }) => format!("{folder}/{name}"),
            None => name,
        };
        Ok(FrameNames { file: within(file), error: error.map(within) })
    }
}

/// The index files that are written; none by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// A list of the pictures that ffmpeg reads.
    pub concat: Option<Concat>,
    /// A database of the pictures by their parameters.
    pub cinema: Option<Cinema>,
}

/// A list of pictures for ffmpeg's demuxer `concat`.
#[derive(Debug, Clone, PartialEq)]
pub struct Concat {
    /// Its file, relative to the directory of the pictures.
    pub file: String,
    /// Pictures per second, positive.
    pub fps: f64,
}

/// A Cinema database (specification D): a folder with pictures and `data.csv`, which has a row of parameters for each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cinema {
    /// Its folder, relative to the directory of the pictures; the pictures lie in it.
    pub folder: String,
    /// Names and values of the picture's parameters beside step and time, in order.
    pub parameters: Vec<(&'static str, String)>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_from_step_and_date() {
        let stamp = Stamp { step: 42, time_s: 0.0, date: Some("0000-01-07_06:30:00".into()) };
        let name = |t: &str| NameTemplate::new(t).unwrap().name(&stamp, "a/b").unwrap();
        assert_eq!(name("{field}_{step:06}.png"), "a_b_000042.png");
        assert_eq!(name("x{step}.exr"), "x42.exr");
        assert_eq!(name("v.$Y-$M-$D_$h.$m.$s.png"), "v.0000-01-07_06.30.00.png");
        assert_eq!(name("plain.png"), "plain.png");
        assert_eq!(name("{field}_{when}.png"), "a_b_0000-01-07_06.30.00_000042.png");
        let dateless = Stamp { date: None, ..stamp.clone() };
        assert_eq!(NameTemplate::new("{when}.png").unwrap().name(&dateless, "f").unwrap(), "000042.png");
        let iso = Stamp { date: Some("2026-11-21T01:02:03Z".into()), ..stamp.clone() };
        assert_eq!(NameTemplate::new("$Y$s.png").unwrap().name(&iso, "f").unwrap(), "202603.png");
    }

    #[test]
    fn a_frame_has_two_names_or_one() {
        let template = |t| NameTemplate::new(t).unwrap();
        let mut output = Output::from(template("{field}_{step}.png"));
        let stamp = Stamp { step: 3, ..Stamp::default() };
        let names = output.names(&stamp, "q").unwrap();
        assert_eq!(names, FrameNames { file: "q_3.png".into(), error: None });
        output.error = Some(template("{field}_error_{step}.png"));
        assert_eq!(output.names(&stamp, "q").unwrap().error.unwrap(), "q_error_3.png");
        output.error = Some(template("q_3.png"));
        assert_eq!(output.names(&stamp, "q").unwrap_err().kind(), ErrorKind::Scene);
        assert!(output.names(&stamp, "r").is_ok());
    }

    #[test]
    fn bad_templates_and_missing_dates_are_refused() {
        for bad in ["x.jpg", "{stp}.png", "{step:6}.png", "{step.png", "}.png", "$Q.png", "{step:099}.png"] {
            assert_eq!(NameTemplate::new(bad).unwrap_err().kind(), ErrorKind::Scene, "{bad}");
        }
        let [dated, when] = ["$Y.png", "{when}.png"].map(|text| NameTemplate::new(text).unwrap());
        for date in [None, Some("yesterday"), Some("2026-01-01"), Some("a-b-c_d:e:f")] {
            let stamp = Stamp { date: date.map(String::from), ..Stamp::default() };
            assert_eq!(dated.name(&stamp, "f").unwrap_err().kind(), ErrorKind::Argument, "{date:?}");
            assert_eq!(when.name(&stamp, "f").unwrap(), "000000.png", "{date:?}");
        }
    }
}
