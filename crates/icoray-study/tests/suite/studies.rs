//! The studies run to their end on small grids and write their results.

use crate::{rows, study};
use std::collections::HashMap;
use std::path::Path;

/// Runs a study with its results in `directory`; returns what it printed.
fn run(words: &[&str], directory: &Path) -> String {
    // Some have fields that need no file.
    let data: &[&str] =
        if ["corners", "ranks", "scale", "speed"].contains(&words[0]) { &[] } else { &["--data", "/nowhere"] };
    let out = ["--out", directory.to_str().unwrap()];
    study(words.iter().chain(&out).chain(data).copied()).unwrap()
}

fn is_chart(path: &Path, words: &[&str]) -> bool {
    let text = std::fs::read_to_string(path).unwrap();
    text.starts_with("<svg") && text.contains("<polyline") && words.iter().all(|w| text.contains(w))
}

#[test]
fn error_leaves_a_table_charts_and_a_verdict() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    let printed = run(&["error", "--quick", "--size", "24", "--repeats", "2"], directory.path());
    let rows = rows(&at("error.csv"));
    let scenes = ["radial", "low_lobes", "stiff_step"];
    // Three rungs of each ladder but the paper's method, which has one.
    assert_eq!(rows.len(), scenes.len() * (8 * 3 + 1));
    for row in &rows {
        assert!(scenes.contains(&row["scene"].as_str()), "{row:?}");
        for key in ["seconds_median", "seconds_min", "rmse", "max_error", "samples"] {
            assert!(row[key].parse::<f64>().unwrap() >= 0.0, "{key} of {row:?}");
        }
        assert_eq!(row["repeats"], "2");
        if row["method"].starts_with("exact") {
            assert!(row["violations"].parse::<usize>().is_ok(), "{row:?}");
        }
    }
    for scene in scenes {
        assert!(is_chart(&at(&format!("{scene}_rmse.svg")), &["exact", "mean value", "RMSE"]));
        assert!(is_chart(&at(&format!("{scene}_max.svg")), &["exact", "paper", "largest"]));
        assert!(printed.contains(&format!("{scene}, RMSE against the oracle: ")), "{printed}");
    }
    let verdict = std::fs::read_to_string(at("verdict.txt")).unwrap();
    assert!(printed.contains(verdict.trim()) && verdict.contains(" of 6."), "{verdict}");
}

#[test]
fn lit_scenes_have_fewer_methods_and_absent_files_are_reported() {
    let directory = tempfile::tempdir().unwrap();
    let words =
        ["error", "--quick", "--close-up", "--size", "16", "--repeats", "1", "--scenes", "radial_lit,jw_theta*"];
    let printed = run(&words, directory.path());
    assert!(printed.contains("jw_theta, jw_theta_lit skipped: no file in /nowhere"), "{printed}");
    let rows = rows(&directory.path().join("error.csv"));
    assert_eq!(rows.len(), 3 * 3 + 1);
}

#[test]
fn ranks_share_out_by_tiles_and_by_parts() {
    let directory = tempfile::tempdir().unwrap();
    let words = "ranks --level 4 --layers 4 --size 40 --ranks 1,3 --frames 1 --node-ranks 1".split(' ');
    let printed = run(&words.collect::<Vec<_>>(), directory.path());
    assert!(printed.contains("2 ranks at once"), "{printed}");
    let rows = rows(&directory.path().join("ranks.csv"));
    assert_eq!(rows.len(), 4 * 4 * 2);
    for row in &rows {
        let number = |key: &str| row[key].parse::<f64>().unwrap();
        let is_one = row["ranks"] == "1";
        // One rank has no other to exchange fragments with.
        let is_parts = row["sharing"] != "tiles" && !is_one;
        assert!(number("busiest_s") > 0.0 && (0.0..=1.0).contains(&number("balance")), "{row:?}");
        assert_eq!(number("fragments_per_pixel") > 0.0, is_parts, "{row:?}");
        assert_eq!(number("sent_bytes_per_rank") > 0.0, !is_one, "{row:?}");
        assert_eq!(number("rank_0_received_bytes") > 0.0, !is_one, "{row:?}");
        assert_eq!(number("compose_s") > 0.0, is_parts, "{row:?}");
        assert!(number("least_tiles") <= number("most_tiles"), "{row:?}");
    }
    let fragments = |sharing: &str| {
        let of = rows.iter().filter(|row| row["sharing"] == sharing && row["ranks"] == "3");
        of.map(|row| row["fragments_per_pixel"].parse::<f64>().unwrap()).sum::<f64>()
    };
    assert!(fragments("random") > 2.0 * fragments("patches"), "random cells cut rays into more pieces");
}

#[test]
fn scale_counts_messages_and_reckons_balance() {
    let directory = tempfile::tempdir().unwrap();
    let page = directory.path().join("page.md");
    std::fs::write(
        &page,
        ["scale", "scale work"].map(|of| format!("<!-- icoray-study {of} -->\n<!-- end -->\n")).concat(),
    )
    .unwrap();
    let words = "scale --level 3 --layers 3 --size 40 --ranks 2,12 --node-ranks 4 --work-level 5 --nodes 1,8 --readme";
    run(&words.split(' ').chain([page.to_str().unwrap()]).collect::<Vec<_>>(), directory.path());
    let page = std::fs::read_to_string(page).unwrap();
    let tables =
        ["| ranks | 2 | 12 |\n|---|---|---|\n| nodes | 1 | 3 |\n", "| nodes | 1 | 8 |\n|---|---|---|\n| balance | "];
    assert!(tables.iter().all(|table| page.contains(table)), "{page}");
    let exchange = rows(&directory.path().join("exchange.csv"));
    let number = |row: &HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    assert_eq!(exchange.len(), 2);
    for row in &exchange {
        let is_node = row["nodes"] == "1";
        assert!(number(row, "network_s") > 0.0 && number(row, "setup_s") > 0.0, "{row:?}");
        assert!(number(row, "messages_per_rank") <= number(row, "most_messages"), "{row:?}");
        assert!(number(row, "sent_bytes_per_rank") <= number(row, "most_sent_bytes"), "{row:?}");
        assert!(number(row, "rank_0_received_bytes_per_pixel") > 1.0, "{row:?}");
        assert_eq!(number(row, "fragments_per_pixel") > 0.0, !is_node, "{row:?}");
        assert_eq!(number(row, "fragment_bytes_per_pixel") > 0.0, !is_node, "{row:?}");
    }
    let work = rows(&directory.path().join("work.csv"));
    assert_eq!(work.len(), 3 * 2);
    for row in &work {
        let is_one = row["nodes"] == "1";
        let balance = number(row, "balance");
        assert!(if is_one { (balance - 1.0).abs() < 1e-9 } else { (0.2..0.9).contains(&balance) }, "{row:?}");
    }
}

#[test]
fn corners_are_measured_beside_their_bases_and_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    std::fs::write(at("README.md"), "<!-- icoray-study corners -->\nold\n<!-- end -->\n").unwrap();
    let readme = at("README.md");
    let words = ["corners", "--size", "2x4", "--pixels", "24", "--frames", "1", "--readme", readme.to_str().unwrap()];
    run(&words, directory.path());
    let rows = rows(&at("corners.csv"));
    assert_eq!(rows.len(), 13);
    let readme = std::fs::read_to_string(&readme).unwrap();
    for row in &rows {
        assert_eq!((row["size"].as_str(), row["base_size"].as_str()), ("2x4", "2x4"));
        assert!(
            readme.contains(&format!("| {} | 2x4 | {} | {} |", row["scene"], row["seconds"], row["base"])),
            "{row:?}"
        );
    }
    let drawn = |name: &str| image::open(at(name)).unwrap().to_rgb8();
    // The same function in more knots, within the errors of both; scenes that differ.
    let [fine, base] = ["991_knots_on_15_lines_2x4.png", "991_knots_on_15_lines_2x4_base.png"].map(drawn);
    assert!(fine.iter().zip(base.iter()).all(|(a, b)| a.abs_diff(*b) <= 1));
    for name in ["layer", "isosurfaces", "256_knots", "two_volumes"] {
        assert_ne!(drawn(&format!("{name}_2x4.png")), drawn(&format!("{name}_2x4_base.png")), "{name}");
    }
    assert_eq!(drawn("four_times_the_pixels_2x4.png").dimensions(), (48, 48));
}

#[test]
fn speed_measures_each_scene_on_each_number_of_threads_and_fills_in_a_readme() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    std::fs::write(at("README.md"), "a\n<!-- icoray-study speed -->\nold\n<!-- end -->\nb\n").unwrap();
    let readme = at("README.md");
    let words = ["speed", "--sizes", "3x5,2x9", "--pixels", "32", "--frames", "2", "--uncounted"];
    let words = [&words[..], &["--readme", readme.to_str().unwrap()]].concat();
    let printed = run(&words, directory.path());
    let rows = rows(&at("speed.csv"));
    // Four transfer functions, lit or not, two tolerances, and the walk alone; one thread and two.
    assert_eq!(rows.len(), 2 * (4 * 2 * 2 + 1) * 2);
    for row in &rows {
        let number = |key: &str| row[key].parse::<f64>().unwrap();
        assert!(number("frame_least_s") > 0.0 && number("frame_least_s") <= number("frame_median_s"), "{row:?}");
        assert!(number("prepare_s") + number("render_s") <= number("frame_least_s") + 1e-5, "{row:?}");
        assert!(number("frusta_crossed") >= number("frusta_read") && number("frusta_read") > 0.0, "{row:?}");
        assert!(number("bytes_read") > 12.0 * number("frusta_read") && number("bandwidth_percent") > 0.0, "{row:?}");
    }
    let find = |transfer: &str, threads: &str| {
        let is = |row: &&HashMap<String, String>| {
            row["transfer"] == transfer && row["threads"] == threads && row["light"] == "unlit"
        };
        rows.iter().find(is).unwrap().clone()
    };
    // No ray ends early where nothing is integrated, and dense has nothing to leap over.
    let (walk, dense, opaque) = (find("walk", "1"), find("dense", "1"), find("opaque", "1"));
    assert_eq!(walk["frusta_read"], dense["frusta_read"]);
    assert!(opaque["frusta_crossed"].parse::<u64>().unwrap() < dense["frusta_crossed"].parse::<u64>().unwrap());
    assert_eq!(find("thin", "1")["frusta_read"], find("thin", "2")["frusta_read"]);
    let text = std::fs::read_to_string(at("speed.md")).unwrap();
    assert!(text.contains("| `icoray-study speed` | dense | lobes | thin shell | opaque |"), "{text}");
    assert!(text.contains("| 642 cells × 5 layers, lit, tolerance 1e-2 |") && printed.contains(&text), "{text}");
    assert!(text.contains("\n| 2 | 162 | "), "{text}");
    let readme = std::fs::read_to_string(readme).unwrap();
    let expected = format!("a\n<!-- icoray-study speed -->\n{text}<!-- end -->\nb\n");
    assert_eq!(readme, expected);
    assert!(at("2x9_opaque_lit_1e-3.png").exists());
}
