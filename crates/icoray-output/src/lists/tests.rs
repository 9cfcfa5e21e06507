//! The exact texts, and existing entries.

use super::*;
use crate::atomic::Existing;
use crate::frame::tests::frame;
use crate::write::write_frame;
use icoray_scene::name::{NameTemplate, Output};
use std::fs;

fn concat(file: &str, fps: f64) -> Option<Concat> {
    Some(Concat { file: file.into(), fps })
}

fn output(file: &str, series: Series) -> Output {
    Output { series, ..NameTemplate::new(file).unwrap().into() }
}

/// Writes pictures of these steps, and returns the text at `path`.
fn written(folder: &Path, output: &Output, steps: &[i64], path: &str) -> String {
    for &step in steps {
        let stamp = Stamp { step, time_s: 600.0 * step as f64, date: None };
        write_frame(folder, output, &stamp, &mut frame(), Existing::Overwrite).unwrap();
    }
    fs::read_to_string(folder.join(path)).unwrap()
}

/// The files of a list, as ffmpeg's `av_get_token` reads them.
fn files(list: &str) -> Vec<String> {
    let lines = list.lines().filter_map(|line| line.strip_prefix("file "));
    let unquoted = |line: &str| {
        let (mut text, mut is_quoted, mut letters) = (String::new(), false, line.chars());
        while let Some(letter) = letters.next() {
            match letter {
                '\'' => is_quoted = !is_quoted,
                '\\' if !is_quoted => text.extend(letters.next()),
                letter => text.push(letter),
            }
        }
        assert!(!is_quoted, "{line}");
        text
    };
    lines.map(unquoted).collect()
}

#[test]
fn a_list_has_each_picture_once_and_is_whole_after_each() {
    let folder = tempfile::tempdir().unwrap();
    let output = output("{field}_{step}.png", Series { concat: concat("movie.ffconcat", 25.0), cinema: None });
    let head = "ffconcat version 1.0\n";
    let entry = |step: i64| format!("file 'q_{step}.png'\nduration 0.04\n");
    let text = written(folder.path(), &output, &[1], "movie.ffconcat");
    assert_eq!(text, format!("{head}{}", entry(1)));
    let text = written(folder.path(), &output, &[2, 3], "movie.ffconcat");
    assert_eq!(text, format!("{head}{}{}{}", entry(1), entry(2), entry(3)));
    // A run that begins again at 2.
    let text = written(folder.path(), &output, &[2, 3, 4], "movie.ffconcat");
    assert_eq!(text, format!("{head}{}{}{}{}", entry(1), entry(2), entry(3), entry(4)));
}

#[test]
fn names_in_a_list_are_quoted_and_lead_from_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let series = |file: &str| Series { concat: concat(file, 10.0), cinema: None };
    for (list, pictures, expected) in [
        ("m.ffconcat", "it's \\ a {step}.png", "it's \\ a 7.png"),
        ("lists/m.ffconcat", "{step}.png", "../7.png"),
        ("lists/n.ffconcat", "lists/a/'{step}'.png", "a/'7'.png"),
        ("lists/l.ffconcat", "b/{step}.png", "../b/7.png"),
    ] {
        let text = written(folder.path(), &output(pictures, series(list)), &[7], list);
        assert_eq!(files(&text), [expected], "{text}");
        let there = folder.path().join(list).parent().unwrap().join(expected);
        assert!(there.is_file(), "{}", there.display());
        assert!(text.ends_with("duration 0.1\n"), "{text}");
    }
}

fn cinema(parameters: &[(&'static str, &str)]) -> Series {
    let parameters = parameters.iter().map(|(name, value)| (*name, (*value).to_owned())).collect();
    Series { concat: None, cinema: Some(Cinema { folder: "runs/q.cdb".into(), parameters }) }
}

#[test]
fn a_database_has_a_row_for_each_set_of_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let path = "runs/q.cdb/data.csv";
    let at = |lon: &str, field: &str| {
        output(&format!("image/{lon}_{{step}}.png"), cinema(&[("lon", lon), ("field", field)]))
    };
    written(folder.path(), &at("0.0", "q"), &[0], path);
    let text = written(folder.path(), &at("22.5", "a \"b\", c"), &[0, 1], path);
    let expected = "step,time,lon,field,FILE\n\
                    0,0.0,0.0,q,image/0.0_0.png\n\
                    0,0.0,22.5,\"a \"\"b\"\", c\",image/22.5_0.png\n\
                    1,600.0,22.5,\"a \"\"b\"\", c\",image/22.5_1.png\n";
    assert_eq!(text, expected);
    assert!(folder.path().join("runs/q.cdb/image/22.5_1.png").is_file());
    // Drawn again, under the same names and under others.
    assert_eq!(written(folder.path(), &at("22.5", "a \"b\", c"), &[0, 1], path), expected);
    let renamed = output("new,{step}.png", cinema(&[("lon", "0.0"), ("field", "q")]));
    let text = written(folder.path(), &renamed, &[0], path);
    assert_eq!(text, expected.replace("image/0.0_0.png", "\"new,0.png\""));
}

#[test]
fn maps_of_errors_are_files_of_a_database() {
    let folder = tempfile::tempdir().unwrap();
    let error = Some(NameTemplate::new("error/{step}.png").unwrap());
    let output = Output { error, ..output("{step}.png", cinema(&[])) };
    let text = written(folder.path(), &output, &[3], "runs/q.cdb/data.csv");
    assert_eq!(text, "step,time,FILE,FILE_error\n3,1800.0,3.png,error/3.png\n");
}

#[test]
fn texts_of_others_are_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let series = Series { concat: concat("m.ffconcat", 25.0), ..cinema(&[("lon", "1.0")]) };
    fs::create_dir_all(folder.path().join("runs/q.cdb")).unwrap();
    for (path, other, head) in [
        ("m.ffconcat", "my notes\n", "ffconcat version 1.0"),
        ("runs/q.cdb/data.csv", "step,time,lat,FILE\n0,0.0,1.0,a.png\n", "step,time,lon,FILE"),
    ] {
        let path = folder.path().join(path);
        fs::write(&path, other).unwrap();
        let checked = || index_files(&series, folder.path(), false).try_for_each(|file| file.check());
        let added = add(&series, folder.path(), &Stamp::default(), &folder.path().join("a.png"), None);
        for error in [checked().unwrap_err(), added.unwrap_err()] {
            assert_eq!(error.kind(), ErrorKind::Exists);
            let said = error.to_string();
            assert!(said.contains(&format!("its first line is not {head:?}")), "{said}");
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), other);
        fs::write(&path, "").unwrap();
        checked().unwrap();
    }
    // A path that is not a file is not opened.
    fs::remove_file(folder.path().join("m.ffconcat")).unwrap();
    fs::create_dir(folder.path().join("m.ffconcat")).unwrap();
    let error = index_files(&series, folder.path(), false).try_for_each(|file| file.check()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Io);
}

#[test]
fn pictures_that_several_add_are_all_there() {
    let folder = tempfile::tempdir().unwrap();
    let series = Series { concat: concat("m.ffconcat", 25.0), cinema: None };
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let (series, folder) = (&series, folder.path());
            scope.spawn(move || {
                for step in 0..10 {
                    let picture = folder.join(format!("{thread}_{step}.png"));
                    add(series, folder, &Stamp::default(), &picture, None).unwrap();
                }
            });
        }
    });
    let list = fs::read_to_string(folder.path().join("m.ffconcat")).unwrap();
    assert_eq!(files(&list).len(), 40, "{list}");
}
