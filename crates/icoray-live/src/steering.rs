//! Which scenes viewers may set where a program writes the pictures that they watch: they change pictures, not where these
//! go, how large they are, or which there are.

use crate::session::{NamedScene, SceneReader};
use icoray::{Error, ErrorKind, Script, View};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// Names of the fields that there are; more may be added while the page is open.
pub type FieldNames = Arc<Mutex<BTreeSet<String>>>;

/// Reads scenes in place of `script`, of these fields alone; `first` is the field of scenes that name none. `[output]`,
/// `[image]`, `[live]` and the names of views must stay.
pub fn steering_reader(script: &Script, first: Option<String>, fields: FieldNames) -> Box<SceneReader> {
    let (live, expected) = (script.live(), kept(script));
    Box::new(move |text| {
        let mut script = Script::parse(text)?;
        script.name_by_date()?;
        if let (true, Some(first)) = (script.lacks_field(), &first) {
            script.name_first_field(first);
        }
        let refused = |what: String| Err(Error::new(ErrorKind::Scene, what));
        if kept(&script) != expected || script.live() != live {
            return refused(
                "live, output, image and the names of views are the model's, which a viewer cannot change".into(),
            );
        }
        let fields = fields.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(missing) = script.model_fields().into_iter().find(|name| !fields.contains(name)) {
            let known: Vec<&str> = fields.iter().map(String::as_str).collect();
            return refused(format!("field {missing:?}, expected one of {}", known.join(", ")));
        }
        let scene = |view: &View| {
            let scene = view.scenes().next();
            let scene = scene.ok_or_else(|| Error::new(ErrorKind::Scene, "the view draws no picture"))?;
            Ok(NamedScene { name: view.name().to_owned(), scene })
        };
        script.views().iter().map(scene).collect()
    })
}

/// What of each view stays: its name, where its pictures go and how large they are.
fn kept(script: &Script) -> Vec<String> {
    let of_scene = |view: &View| {
        let scenes = view.scenes().map(|scene| format!("{} x {}, {:?}", scene.width, scene.height, scene.output));
        format!("{:?}: {}", view.name(), scenes.collect::<Vec<_>>().join("; "))
    };
    script.views().iter().map(of_scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viewers_change_pictures_and_not_where_they_go() {
        let text = "field = 'q'\n[live]\n[image]\nwidth = 64\n[output]\nfile = 'a_{step}.png'\n";
        let fields = FieldNames::new(Mutex::new(["q", "w"].map(str::to_owned).into()));
        let read = steering_reader(&Script::parse(text).unwrap(), Some("q".to_owned()), fields);
        for good in
            [text.replace("'q'", "'w'"), format!("camera.lon = 40\nevery = 3\n{text}"), text.replace("field = 'q'", "")]
        {
            assert_eq!(read(&good).unwrap().len(), 1, "{good}");
        }
        for (bad, wanted) in [
            (text.replace("a_{step}", "../b_{step}"), "output"),
            (text.replace("a_{step}", "b_{step}"), "live, output, image and the names of views are the model's"),
            (text.replace("64", "6400"), "the model's"),
            (text.replace("[live]", "[live]\nport = 99"), "the model's"),
            (text.replace("[live]", ""), "the model's"),
            (format!("{text}[[views]]\nname = 'a'\n"), "the model's"),
            (text.replace("'q'", "'z'"), "field \"z\", expected one of q, w"),
            ("field = ".to_owned(), "line 1"),
        ] {
            let error = read(&bad).unwrap_err().to_string();
            assert!(error.contains(wanted), "{bad}: {error}");
        }
    }
}
