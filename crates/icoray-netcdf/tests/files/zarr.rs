//! Zarr stores, written by the NetCDF library and by the tests.

use crate::made::{Made, MadeVariable, RECORDS, Values};
use crate::memory::{self, expect};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use icoray::ErrorKind;
use icoray_netcdf::{Dataset, Outline};
use icoray_test_support::{Need, skip};
use netcdf::Options;
use serde_json::{Map, Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use tempfile::TempDir;
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

/// Writes a history as a store of Zarr alone, as xarray does, or of NCZarr; skips the test where the library has no Zarr.
fn write(made: &Made, mode: &str) -> Option<(TempDir, PathBuf)> {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("made.zarr");
    let address = format!("file://{}#mode={mode},file", store.display());
    if netcdf::create_with(&address, Options::NETCDF4).is_err() {
        skip(Need::Zarr);
        return None;
    }
    made.write_to(address.as_ref(), Options::NETCDF4);
    Some((folder, store))
}

/// A history whose times are numbers and not unlimited, which not every version of NCZarr has.
fn history() -> Made {
    let mut made = Made::history();
    made.dimensions.iter_mut().filter(|(name, _)| *name == "Time").for_each(|(_, len)| *len = RECORDS);
    made.remove("xtime");
    made.add("Time", &["Time"], Values::F64(vec![0.0, 1.0, 2.0])).attributes =
        vec![("units", "days since 2000-01-01".into())];
    made
}

#[test]
fn stores_are_read_by_their_folders_and_by_their_addresses() {
    let made = history();
    let expected = memory::open(&made);
    for mode in ["zarr", "nczarr"] {
        let Some((_folder, store)) = write(&made, mode) else { return };
        let name = store.display().to_string();
        for name in [name.clone(), format!("{name}#mode=zarr,file"), format!("file://{name}#mode=nczarr,file")] {
            assert!(!Outline::is_classic(&name).unwrap(), "a process of its own reads it");
            let file = icoray_netcdf::open(&name).unwrap();
            // The library writes the mark of double values with six digits.
            expect_same(&file, &expected, &["theta", "rho"], &name);
        }
    }
}

fn expect_same(file: &Dataset, expected: &Dataset, fields: &[&str], name: &str) {
    assert!(file.mesh().is_same(expected.mesh()), "{name}");
    assert_eq!(file.times(), expected.times(), "{name}");
    for field in fields {
        let [found, expected] = [file, expected].map(|dataset| dataset.read_field(field, 1).unwrap());
        assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{name}: {field}");
    }
}

/// Writes a dataset as xarray and zarr of Python do: packed, one chunk per time, metadata consolidated.
fn write_packed(made: &Made, version: u32, store: &Path) {
    let mut documents = Map::new();
    let root =
        Value::Object(made.attributes.iter().map(|(name, value)| ((*name).to_owned(), json_of(value))).collect());
    let group = json!({"zarr_format": version});
    if version == 2 {
        documents.insert(".zgroup".to_owned(), group);
        documents.insert(".zattrs".to_owned(), root.clone());
    }
    for variable in &made.variables {
        write_array(made, variable, version, store, &mut documents);
    }
    for (key, document) in &documents {
        let file = if version == 2 { store.join(key) } else { store.join(key).join("zarr.json") };
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, document.to_string()).unwrap();
    }
    let (name, all) = match version {
        2 => (".zmetadata", json!({"metadata": documents, "zarr_consolidated_format": 1})),
        _ => (
            "zarr.json",
            json!({"zarr_format": 3, "node_type": "group", "attributes": root,
                   "consolidated_metadata": {"kind": "inline", "must_understand": false, "metadata": documents}}),
        ),
    };
    fs::write(store.join(name), all.to_string()).unwrap();
}

fn write_array(made: &Made, variable: &MadeVariable, version: u32, store: &Path, documents: &mut Map<String, Value>) {
    let MadeVariable { name, dimensions, values, attributes } = variable;
    let attributes = attributes.iter().map(|(name, value)| ((*name).to_owned(), json_of(value)));
    let mut attributes: Map<String, Value> = attributes.collect();
    let mut shape: Vec<usize> = dimensions.iter().map(|name| made.dimension(name)).collect();
    let mut dimensions = dimensions.clone();
    let (types, bytes): (_, Vec<u8>) = match values {
        Values::F32(v) => (["<f4", "float32"].map(Value::from), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Values::F64(v) => (["<f8", "float64"].map(Value::from), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Values::I32(v) => (["<i4", "int32"].map(Value::from), v.iter().flat_map(|x| x.to_le_bytes()).collect()),
        Values::Text(v) => {
            let len = shape.pop().unwrap();
            dimensions.pop();
            let named = json!({"name": "null_terminated_bytes", "configuration": {"length_bytes": len}});
            ([json!(format!("|S{len}")), named], v.clone())
        }
    };
    let is_text = matches!(values, Values::Text(_));
    let mut chunks = shape.clone();
    if dimensions[0] == "Time" {
        chunks[0] = 1;
    }
    let separator = if version == 2 { "." } else { "/" };
    let rest = vec!["0"; shape.len() - 1];
    for (k, chunk) in bytes.chunks(bytes.len() * chunks[0] / shape[0]).enumerate() {
        let k = k.to_string();
        let key = [&[k.as_str()], &rest[..]].concat().join(separator);
        let file = store.join(name).join(if version == 2 { key } else { format!("c/{key}") });
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, packed(chunk, version)).unwrap();
    }
    let [old, new] = types;
    if version == 2 {
        attributes.insert("_ARRAY_DIMENSIONS".to_owned(), json!(dimensions));
        documents.insert(format!("{name}/.zattrs"), Value::Object(attributes));
        let metadata = json!({"zarr_format": 2, "shape": shape, "chunks": chunks, "dtype": old, "order": "C",
            "fill_value": null, "filters": null, "compressor": {"id": "zlib", "level": 1}});
        documents.insert(format!("{name}/.zarray"), metadata);
    } else {
        let codecs = json!([{"name": "bytes", "configuration": {"endian": "little"}},
            {"name": "gzip", "configuration": {"level": 1}}]);
        let codecs = if is_text { json!([{"name": "bytes"}, codecs[1]]) } else { codecs };
        let metadata = json!({"zarr_format": 3, "node_type": "array", "shape": shape, "data_type": new,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunks}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
            "fill_value": if is_text { json!("") } else { json!(0) }, "codecs": codecs,
            "dimension_names": dimensions, "attributes": attributes});
        documents.insert((*name).to_owned(), metadata);
    }
}

fn json_of(value: &Values) -> Value {
    match value {
        Values::F32(v) => json!(v[0]),
        Values::F64(v) => json!(v[0]),
        Values::I32(v) => json!(v[0]),
        Values::Text(text) => json!(String::from_utf8_lossy(text)),
    }
}

fn packed(bytes: &[u8], version: u32) -> Vec<u8> {
    if version == 2 {
        let mut to = ZlibEncoder::new(Vec::new(), Compression::fast());
        to.write_all(bytes).unwrap();
        return to.finish().unwrap();
    }
    let mut to = GzEncoder::new(Vec::new(), Compression::fast());
    to.write_all(bytes).unwrap();
    to.finish().unwrap()
}

/// The address of a server of the files in a folder, which may know ranges of bytes.
fn serve(folder: PathBuf, knows_ranges: bool) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    thread::spawn(move || listener.incoming().for_each(|stream| answer(stream.unwrap(), &folder, knows_ranges)));
    address
}

fn answer(mut stream: TcpStream, folder: &Path, knows_ranges: bool) {
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
    let Some(request) = lines.next() else { return };
    let headers: Vec<String> = lines.take_while(|line| !line.is_empty()).map(|line| line.to_lowercase()).collect();
    let range = headers.iter().find_map(|header| header.strip_prefix("range: bytes=")).filter(|_| knows_ranges);
    let path = request.split(' ').nth(1).unwrap().trim_start_matches('/');
    let (status, body) = match (fs::read(folder.join(path)), range) {
        (Ok(bytes), None) => ("200 OK", bytes),
        (Ok(bytes), Some(range)) => {
            let (first, last) = range.split_once('-').unwrap();
            let number = |text: &str| text.parse::<usize>().ok();
            let part = match (number(first), number(last)) {
                (Some(first), Some(last)) => &bytes[first..=last],
                (Some(first), None) => &bytes[first..],
                (None, last) => &bytes[bytes.len() - last.unwrap()..],
            };
            ("206 Partial Content", part.to_vec())
        }
        (Err(_), _) => ("404 Not Found", Vec::new()),
    };
    let head = format!("HTTP/1.1 {status}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
    // A client that has left is none of the server's errors.
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&body));
}

/// Shards are read in parts: their index at the end, then the chunks, also from servers that send all of them.
#[test]
fn shards_are_read_from_web_servers_that_know_ranges_and_from_others() {
    let (mut made, folder) = (Made::history(), tempfile::tempdir().unwrap());
    let store = folder.path().join("made.zarr");
    write_packed(&made, 3, &store);
    fs::remove_dir_all(store.join("theta/c")).unwrap();
    let file = store.join("zarr.json");
    let mut root: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    let metadata = &mut root["consolidated_metadata"]["metadata"]["theta"];
    // All times are in one shard.
    metadata["chunk_grid"]["configuration"]["chunk_shape"] = metadata["shape"].clone();
    let bytes = json!({"name": "bytes", "configuration": {"endian": "little"}});
    metadata["codecs"] = json!([{"name": "sharding_indexed", "configuration": {"chunk_shape": [1, 7, 2],
        "codecs": [bytes, {"name": "zstd", "configuration": {"level": 1, "checksum": false}}],
        "index_location": "end", "index_codecs": [bytes, {"name": "crc32c"}]}}]);
    let typed = serde_json::from_value(metadata.clone()).unwrap();
    let values = made.f32s("theta").clone();
    let to = Arc::new(FilesystemStore::new(&store).unwrap());
    let array = Array::new_with_metadata(to, "/theta", typed).unwrap();
    array.store_array_subset_elements(&array.subset_all(), &values).unwrap();
    fs::write(&file, root.to_string()).unwrap();
    for knows_ranges in [true, false] {
        let name = format!("{}/made.zarr", serve(folder.path().to_owned(), knows_ranges));
        expect_same(&icoray_netcdf::open(&name).unwrap(), &memory::open(&made), &["theta"], &name);
    }
}

#[test]
fn packed_stores_of_both_versions_are_read_from_folders_groups_and_web_servers() {
    let (made, folder) = (Made::history(), tempfile::tempdir().unwrap());
    let expected = memory::open(&made);
    let server = serve(folder.path().to_owned(), true);
    for version in [2, 3] {
        let name = format!("made{version}.zarr");
        let store = folder.path().join(&name);
        write_packed(&made, version, &store);
        for name in [store.display().to_string(), format!("{server}/{name}"), format!("{server}/{name}/#mode=zarr")] {
            expect_same(&icoray_netcdf::open(&name).unwrap(), &expected, &["theta", "rho", "w"], &name);
        }
    }
}

/// As stores have them that hold one dataset for each resolution.
#[test]
fn a_group_of_a_store_is_a_store() {
    let (mut made, folder) = (Made::history(), tempfile::tempdir().unwrap());
    // Another planet's: without the attributes of its group a store has the Earth's.
    made.attributes = vec![("on_a_sphere", "YES".into()), ("sphere_radius", 3_389_500.0.into())];
    let server = serve(folder.path().to_owned(), true);
    for version in [2, 3] {
        let own_name = format!("levels{version}.zarr");
        let store = folder.path().join(&own_name);
        write_groups(&made, version, &store);
        for name in [store.display().to_string(), format!("{server}/{own_name}")] {
            let file = icoray_netcdf::open(format!("{name}/z1")).unwrap();
            assert_eq!(file.sphere_radius_m(), 3_389_500.0, "{name}");
            expect_same(&file, &memory::open(&made), &["w"], &name);
            let parts = [&name, "groups z0, z1 have variables of the same names, expected one: ", "zarr/z1"];
            expect(&icoray_netcdf::open(&name).unwrap_err(), ErrorKind::Io, &parts);
        }
    }
}

/// Writes a dataset as two groups of a store, whose metadata are consolidated at its root alone.
fn write_groups(made: &Made, version: u32, store: &Path) {
    let (mark, mut all) = (if version == 2 { ".zmetadata" } else { "zarr.json" }, Map::new());
    for group in ["z0", "z1"] {
        write_packed(made, version, &store.join(group));
        let file = store.join(group).join(mark);
        let mut own: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
        if version == 2 {
            fs::remove_file(file).unwrap();
        } else {
            let root = json!({"zarr_format": 3, "node_type": "group", "attributes": own["attributes"]});
            fs::write(file, root.to_string()).unwrap();
            all.insert(group.to_owned(), root);
            own = own["consolidated_metadata"].take();
        }
        let own = own["metadata"].as_object().unwrap().iter();
        all.extend(own.map(|(key, document)| (format!("{group}/{key}"), document.clone())));
    }
    let all = json!({"metadata": all, "kind": "inline", "must_understand": false});
    let root = if version == 2 {
        all
    } else {
        json!({"zarr_format": 3, "node_type": "group", "attributes": {}, "consolidated_metadata": all})
    };
    fs::write(store.join(mark), root.to_string()).unwrap();
}

/// Changes the metadata of `rho` in a store of version 3, without its chunks: its values are then marks.
fn with_rho(change: impl Fn(&mut Value)) -> icoray::Result<Dataset> {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("made.zarr");
    write_packed(&Made::history(), 3, &store);
    fs::remove_dir_all(store.join("rho/c")).unwrap();
    let file = store.join("rho/zarr.json");
    let mut metadata = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    change(&mut metadata);
    fs::write(&file, metadata.to_string()).unwrap();
    let opened = icoray_netcdf::open(&store)?;
    opened.read_field("rho", 0)?;
    Ok(opened)
}

#[test]
fn the_codecs_of_the_field_are_known_and_others_are_refused_with_their_readers() {
    let blosc = json!({"cname": "zstd", "clevel": 5, "shuffle": "shuffle", "typesize": 4, "blocksize": 0});
    let bytes = json!({"name": "bytes", "configuration": {"endian": "big"}});
    let sharding = json!({"chunk_shape": [1, 1], "codecs": [bytes], "index_location": "end",
        "index_codecs": [bytes, {"name": "crc32c"}]});
    for codecs in [
        json!([bytes, {"name": "blosc", "configuration": blosc}]),
        json!([bytes, {"name": "zstd", "configuration": {"level": 3, "checksum": false}}]),
        json!([{"name": "sharding_indexed", "configuration": sharding}]),
        json!([{"name": "transpose", "configuration": {"order": [1, 0]}}, bytes]),
    ] {
        with_rho(|metadata| metadata["codecs"] = codecs.clone()).unwrap();
    }
    let parts = ["made.zarr: variable rho", "none of the codecs", "in Python `icoray.open(", "with xarray and zarr"];
    let refused = with_rho(|metadata| metadata["codecs"] = json!([bytes, {"name": "none of the codecs"}]));
    expect(&refused.unwrap_err(), ErrorKind::Io, &parts);
}

/// Texts of a length that no memory has are none.
#[test]
fn the_rest_of_a_store_with_endless_texts_is_read() {
    let (made, folder) = (Made::history(), tempfile::tempdir().unwrap());
    let store = folder.path().join("made.zarr");
    write_packed(&made, 2, &store);
    let endless = r#"{"zarr_format": 2, "shape": [3], "chunks": [3], "dtype": "|S9000000000000000", "order": "C",
        "fill_value": null, "filters": null, "compressor": null}"#;
    fs::write(store.join("xtime/.zarray"), endless).unwrap();
    let file = icoray_netcdf::open(&store).unwrap();
    assert_eq!(file.times().to_vec(), vec![None; RECORDS]);
    assert_eq!(file.read_field("theta", 1).unwrap().field().unwrap().shape().columns, made.dimension("nCells"));
}

#[test]
fn stores_that_cannot_be_read_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("made.zarr");
    write_packed(&Made::history(), 2, &store);
    let open = |name: &str| icoray_netcdf::open(name).unwrap_err();
    fs::remove_file(store.join(".zmetadata")).unwrap();
    let address = format!("{}/made.zarr", serve(folder.path().to_owned(), true));
    expect(&open(&address), ErrorKind::Io, &[&address, "no consolidated metadata", "zarr.consolidate_metadata"]);
    expect(&open("s3://bucket/made.zarr"), ErrorKind::Io, &["expected the bucket's https:// address"]);
    expect(&open("http://127.0.0.1:1/made.zarr"), ErrorKind::Io, &["http://127.0.0.1:1/made.zarr/zarr.json"]);
    let absent = format!("file://{}#mode=nczarr,file", folder.path().join("none").display());
    expect(&open(&absent), ErrorKind::Io, &[&absent, "No such file"]);
    fs::write(store.join("theta/.zarray"), "{").unwrap();
    expect(&open(&store.display().to_string()), ErrorKind::Io, &["made.zarr", "theta/.zarray", "EOF"]);
    fs::write(store.join("theta/.zarray"), "[]").unwrap();
    expect(&open(&store.display().to_string()), ErrorKind::Io, &["theta/.zarray: [], expected an object"]);
    fs::write(store.join("theta/.zarray"), r#"{"shape": [-1]}"#).unwrap();
    expect(&open(&store.display().to_string()), ErrorKind::Io, &["variable theta: length -1"]);
}
