//! Zarr stores of versions 2 and 3 in folders and on web servers, whose arrays the crate `zarrs` unpacks.
//!
//! Zarr has no dimensions: xarray stores their names as attributes in version 2, NCZarr in a document of its own.
//! Formats: <https://zarr-specs.readthedocs.io>, <https://docs.xarray.dev/en/stable/internals/zarr-encoding-spec.html>.

mod web;

use crate::nc_file::trimmed;
use icoray::{Error, ErrorKind, OwnedReals, Result};
use icoray_dataset::{Attribute, Dimension, Kind, Source, Variable};
use serde_json::{Map, Value, json};
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::{Array, ArrayMetadata, ArrayMetadataOptions, DataType, ElementOwned};
use zarrs::array_subset::ArraySubset;
use zarrs::config::MetadataConvertVersion;
use zarrs::filesystem::FilesystemStore;
use zarrs::storage::{ReadableStorage, ReadableStorageTraits, StoreKey};

/// Entries of a folder of which one is in each store: of version 2, consolidated, and of version 3.
const MARKS: [&str; 3] = [".zgroup", ".zmetadata", "zarr.json"];

/// Largest number of bytes of a text.
const LONGEST_TEXT: usize = 1 << 16;

/// Where a store is.
pub(crate) enum Location {
    Folder(PathBuf),
    /// An address, without a mode behind `#`.
    Web(String),
    /// A bucket of which the web address is not given.
    Bucket,
}

impl Location {
    /// The store that a name means: a folder with metadata of Zarr, the address of a `.zarr`, or a name with a mode of
    /// the NetCDF library behind `#` that contains `zarr`. `None` for files.
    pub fn of(path: &Path) -> Option<Self> {
        let text = path.to_string_lossy();
        let (name, mode) = text.split_once('#').unwrap_or((&text, ""));
        let is_said = mode.contains("zarr");
        let is_named = name.split('/').any(|part| part.ends_with(".zarr"));
        match name.split_once("://") {
            Some(("file", folder)) if is_said => Some(Location::Folder(folder.into())),
            Some(("http" | "https", _)) if is_said || is_named => Some(Location::Web(name.to_owned())),
            Some(("s3", _)) if is_said || is_named => Some(Location::Bucket),
            None if is_said => Some(Location::Folder(name.into())),
            None if MARKS.iter().any(|mark| path.join(mark).exists()) => Some(Location::Folder(path.to_owned())),
            _ => None,
        }
    }
}

/// An open store.
pub(crate) struct ZarrStore {
    path: PathBuf,
    attributes: Map<String, Value>,
    arrays: HashMap<String, StoredArray>,
    variables: Vec<Variable>,
}

/// An array with its attributes, or the reason why it cannot be read.
struct StoredArray {
    attributes: Map<String, Value>,
    array: std::result::Result<Array<dyn ReadableStorageTraits>, String>,
}

impl fmt::Debug for ZarrStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ZarrStore")
            .field("path", &self.path)
            .field("variables", &self.variables)
            .finish_non_exhaustive()
    }
}

impl ZarrStore {
    /// Reads the metadata of all arrays, also of those in groups.
    pub fn open(path: &Path, location: &Location) -> Result<Self> {
        let error = |what: String| Error::new(ErrorKind::Io, format!("{}: {what}", path.display()));
        let documents = Documents::read(location).map_err(error)?;
        expect_one_group(path, &documents.arrays).map_err(error)?;
        let root = documents.of_node("").map_err(error)?.unwrap_or_default();
        let (mut arrays, mut variables) = (HashMap::new(), Vec::new());
        for name in &documents.arrays {
            let Some(metadata) = documents.of_node(name).map_err(error)? else { continue };
            variables.push(variable(name, &metadata).map_err(error)?);
            let attributes = attributes_of(&metadata);
            let array = array(&documents.store, name, metadata);
            arrays.insert(name.clone(), StoredArray { attributes, array });
        }
        let mut opened = ZarrStore { path: path.to_owned(), attributes: attributes_of(&root), arrays, variables };
        opened.variables = (&opened as &dyn Source).with_time_marked();
        Ok(opened)
    }

    fn error(&self, variable: &Variable, what: impl fmt::Display) -> Error {
        let store = self.path.display();
        (self as &dyn Source).error(
            ErrorKind::Io,
            format_args!(
                "variable {variable}: {what}; in Python `icoray.open(\"{store}\")` reads it with xarray and zarr"
            ),
        )
    }

    fn array(&self, variable: &Variable) -> Result<&Array<dyn ReadableStorageTraits>> {
        let stored = self.arrays.get(&variable.name).map(|stored| stored.array.as_ref());
        stored.unwrap_or(Err(&String::new())).map_err(|what| self.error(variable, what))
    }

    fn block<T: ElementOwned>(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Vec<T>> {
        let block = self.subset(variable, start, count, size_of::<T>())?;
        self.array(variable)?.retrieve_array_subset_elements(&block).map_err(|e| self.error(variable, e))
    }

    /// A block of entries of this many bytes each.
    fn subset(&self, variable: &Variable, start: &[usize], count: &[usize], bytes: usize) -> Result<ArraySubset> {
        let total = count.iter().try_fold(bytes, |n, &c| n.checked_mul(c));
        // Damaged metadata may promise more than there can be; running out of memory must not end the process.
        let has_room = total.is_some_and(|n| Vec::<u8>::new().try_reserve_exact(n).is_ok());
        if !has_room {
            return Err(self.error(variable, "too large for the memory"));
        }
        // The dimension of a text's bytes is none of the array's.
        let dimensions = self.array(variable)?.dimensionality();
        let wide = |numbers: &[usize]| numbers[..dimensions].iter().map(|&n| n as u64).collect();
        ArraySubset::new_with_start_shape(wide(start), wide(count)).map_err(|e| self.error(variable, e))
    }
}

impl Source for ZarrStore {
    fn path(&self) -> &Path {
        &self.path
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn attribute(&self, variable: Option<&str>, name: &str) -> Result<Option<Attribute>> {
        let Some(variable) = variable else {
            return Ok(self.attributes.get(name).and_then(attribute));
        };
        let stored = self.arrays.get(variable);
        let value = stored.and_then(|stored| stored.attributes.get(name));
        let is_real = (self as &dyn Source).variable(variable).is_some_and(|variable| variable.kind.is_real());
        Ok(match value {
            Some(Value::String(text)) if name == "_FillValue" && is_real => real_mark(text),
            value => value.and_then(attribute),
        })
    }

    fn reals(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<OwnedReals> {
        macro_rules! widened {
            ($type:ty, $widen:expr) => {
                OwnedReals::F64(self.block::<$type>(variable, start, count)?.into_iter().map($widen).collect())
            };
        }
        Ok(match self.array(variable)?.data_type() {
            DataType::Float32 => OwnedReals::F32(self.block(variable, start, count)?),
            DataType::Float64 => OwnedReals::F64(self.block(variable, start, count)?),
            DataType::Bool => widened!(bool, f64::from),
            DataType::Int8 => widened!(i8, f64::from),
            DataType::Int16 => widened!(i16, f64::from),
            DataType::Int32 => widened!(i32, f64::from),
            DataType::Int64 => widened!(i64, |x| x as f64),
            DataType::UInt8 => widened!(u8, f64::from),
            DataType::UInt16 => widened!(u16, f64::from),
            DataType::UInt32 => widened!(u32, f64::from),
            DataType::UInt64 => widened!(u64, |x| x as f64),
            other => return Err(self.error(variable, format_args!("type {other}, expected numbers of up to 64 bits"))),
        })
    }

    fn text_rows(&self, variable: &Variable, rows: usize) -> Vec<Option<String>> {
        let count = rows.min(variable.dimensions[0].len);
        let (start, mut shape) = variable.whole();
        shape[0] = count;
        let read = || -> Option<Vec<String>> {
            let array = self.array(variable).ok()?;
            if *array.data_type() == DataType::String {
                return self.block(variable, &start, &shape).ok();
            }
            let block = self.subset(variable, &start, &shape, 1).ok()?;
            let bytes = array.retrieve_array_subset(&block).ok()?.into_fixed().ok()?;
            let row = |row: &[u8]| String::from_utf8_lossy(row).into_owned();
            Some(bytes.chunks(shape[1].max(1)).map(row).collect())
        };
        let mut texts: Vec<_> = read().iter().flatten().map(|text| Some(trimmed(text))).collect();
        texts.resize(rows, None);
        texts
    }
}

/// The metadata documents of a store: consolidated in one, or each by itself.
struct Documents {
    store: ReadableStorage,
    /// Names of the arrays, in the order of the alphabet.
    arrays: Vec<String>,
    /// The documents by their keys, if they are consolidated.
    consolidated: Option<Map<String, Value>>,
}

/// What fails, for an error that names the store.
type Found<T> = std::result::Result<T, String>;

impl Documents {
    fn read(location: &Location) -> Found<Self> {
        match location {
            Location::Folder(folder) => {
                let store = FilesystemStore::new(folder).map_err(|e| e.to_string())?;
                let mut arrays = Vec::new();
                find_arrays(folder, "", &mut arrays).map_err(|e| e.to_string())?;
                arrays.sort();
                Ok(Documents { store: Arc::new(store), arrays, consolidated: None })
            }
            Location::Web(address) => Self::consolidated(address),
            Location::Bucket => Err("a Zarr store in a bucket, expected the bucket's https:// address".to_owned()),
        }
    }

    /// The documents of a store, or of a group whose store has them.
    fn consolidated(address: &str) -> Found<Self> {
        let at = |address: &str| Documents {
            store: Arc::new(web::WebStore::new(address)),
            arrays: Vec::new(),
            consolidated: None,
        };
        let mut documents = at(address);
        let mut all = documents.all()?;
        let (mut outer, mut group) = (address.trim_end_matches('/'), String::new());
        while all.is_none() && outer.contains(".zarr/") {
            let (rest, own) = outer.rsplit_once('/').unwrap_or_default();
            (outer, group) = (rest, format!("{own}/{group}"));
            all = at(outer).all()?;
        }
        let all = all.ok_or(
            "no consolidated metadata, which stores on web servers need: `zarr.consolidate_metadata` of Python",
        )?;
        let of_group = |(key, document): (String, Value)| {
            let is_group = key.len() + 1 == group.len() && group.starts_with(&key);
            Some((if is_group { String::new() } else { key.strip_prefix(&group)?.to_owned() }, document))
        };
        let all: Map<String, Value> = all.into_iter().filter_map(of_group).collect();
        let array_of = |(key, document): (&String, &Value)| match document["node_type"] == "array" {
            true => Some(key.clone()),
            false => key.strip_suffix("/.zarray").map(str::to_owned),
        };
        documents.arrays = all.iter().filter_map(array_of).collect();
        documents.arrays.sort();
        documents.consolidated = Some(all);
        Ok(documents)
    }

    /// The consolidated documents by their keys; the root of version 3 has none.
    fn all(&self) -> Found<Option<Map<String, Value>>> {
        if let Some(Value::Object(mut root)) = self.document("zarr.json")? {
            let all = root.remove("consolidated_metadata").and_then(|mut all| all.get_mut("metadata").map(Value::take));
            if let Some(Value::Object(mut all)) = all {
                all.insert(String::new(), Value::Object(root));
                return Ok(Some(all));
            }
        }
        let all = self.document(".zmetadata")?.and_then(|mut all| all.get_mut("metadata").map(Value::take));
        Ok(all.and_then(|all| if let Value::Object(all) = all { Some(all) } else { None }))
    }

    fn document(&self, key: &str) -> Found<Option<Value>> {
        if let Some(all) = &self.consolidated {
            return Ok(all.get(key).filter(|document| document.is_object()).cloned());
        }
        let words = |e: &dyn fmt::Display| format!("{key}: {e}");
        let stored = self.store.get(&StoreKey::new(key).map_err(|e| words(&e))?).map_err(|e| words(&e))?;
        let document: Option<Value> =
            stored.map(|bytes| serde_json::from_slice(&bytes).map_err(|e| words(&e))).transpose()?;
        match document {
            Some(other) if !other.is_object() => Err(words(&format_args!("{other}, expected an object"))),
            document => Ok(document),
        }
    }

    /// The metadata of an array or, without a name, of the root, with its attributes.
    fn of_node(&self, name: &str) -> Found<Option<Value>> {
        let key = |document: &str| if name.is_empty() { document.to_owned() } else { format!("{name}/{document}") };
        let of_version_3 = if self.consolidated.is_some() { name.to_owned() } else { key("zarr.json") };
        if let Some(metadata) = self.document(&of_version_3)? {
            return Ok(Some(metadata));
        }
        let group = || Ok::<_, String>(Some(json!({})));
        let Some(mut metadata) = (if name.is_empty() { group() } else { self.document(&key(".zarray")) })? else {
            return Ok(None);
        };
        metadata["attributes"] = self.document(&key(".zattrs"))?.unwrap_or_else(|| json!({}));
        if let Some(of_netcdf) = self.document(&key(".nczarray"))? {
            metadata["_NCZARR_ARRAY"] = of_netcdf;
        }
        Ok(Some(metadata))
    }
}

/// Fails for a store of groups with arrays of the same names, such as one for each resolution.
fn expect_one_group(path: &Path, arrays: &[String]) -> Found<()> {
    let Some(parts) = arrays.iter().map(|name| name.split_once('/')).collect::<Option<Vec<_>>>() else { return Ok(()) };
    let mut names = HashSet::new();
    if parts.iter().all(|(_, name)| names.insert(name)) {
        return Ok(());
    }
    let mut groups: Vec<&str> = parts.iter().map(|(group, _)| *group).collect();
    groups.dedup();
    let text = path.to_string_lossy();
    let (store, mode) = text.split_at(text.find('#').unwrap_or(text.len()));
    let one = groups[groups.len() - 1];
    let groups = groups.join(", ");
    Err(format!("groups {groups} have variables of the same names, expected one: {store}/{one}{mode}"))
}

/// Adds the names of the arrays in a folder and in its groups.
fn find_arrays(folder: &Path, name: &str, arrays: &mut Vec<String>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        let own = entry.file_name().to_string_lossy().into_owned();
        let name = if name.is_empty() { own } else { format!("{name}/{own}") };
        let is_array = path.join(".zarray").exists()
            || fs::read(path.join("zarr.json")).is_ok_and(|bytes| {
                serde_json::from_slice(&bytes).is_ok_and(|metadata: Value| metadata["node_type"] == "array")
            });
        if is_array {
            arrays.push(name);
        } else if MARKS.iter().any(|mark| path.join(mark).exists()) {
            find_arrays(&path, &name, arrays)?;
        }
    }
    Ok(())
}

fn attributes_of(metadata: &Value) -> Map<String, Value> {
    let mut attributes = metadata["attributes"].as_object().cloned().unwrap_or_default();
    // Version 2 has the mark of missing values here.
    if metadata["zarr_format"] == 2 && !metadata["fill_value"].is_null() {
        attributes.entry("_FillValue").or_insert_with(|| metadata["fill_value"].clone());
    }
    attributes
}

/// Name, type and dimensions of an array.
fn variable(name: &str, metadata: &Value) -> Found<Variable> {
    let lengths = metadata["shape"].as_array().ok_or_else(|| format!("variable {name}: its metadata have no shape"))?;
    let of_netcdf = &metadata["_NCZARR_ARRAY"]["dimrefs"];
    let lists = [&metadata["dimension_names"], &metadata["attributes"]["_ARRAY_DIMENSIONS"], of_netcdf];
    let names = lists.into_iter().find_map(Value::as_array);
    let group = name.rsplit_once('/').map(|(group, _)| format!("{group}/")).unwrap_or_default();
    let dimension = |(k, len): (usize, &Value)| {
        let len = len.as_u64().and_then(|len| usize::try_from(len).ok()).ok_or_else(|| format!("length {len}"))?;
        let own = names.and_then(|names| names.get(k)?.as_str()).map(|name| name.rsplit('/').next().unwrap_or(name));
        let own = own.map_or_else(|| format!("dimension_of_{len}"), str::to_owned);
        Ok(Dimension::new(format!("{group}{own}"), len))
    };
    let dimensions = lengths.iter().enumerate().map(dimension).collect::<Found<Vec<_>>>();
    let mut dimensions = dimensions.map_err(|e| format!("variable {name}: {e}, expected a number of entries"))?;
    let text_len = text_len(metadata);
    let kind = match (text_len, dimensions.len()) {
        (Some(1), 2) => Kind::Text,
        (Some(len), 1) => {
            dimensions.push(Dimension::new(format!("{group}StrLen"), len));
            Kind::Text
        }
        (Some(_), _) => Kind::Other,
        (None, _) => kind(type_name(metadata)),
    };
    Ok(Variable { name: name.to_owned(), kind, dimensions })
}

/// The type's name: NumPy's with the order of bytes in version 2, Zarr's own in version 3.
fn type_name(metadata: &Value) -> &str {
    let kind = if metadata["dtype"].is_null() { &metadata["data_type"] } else { &metadata["dtype"] };
    kind.as_str().or(kind["name"].as_str()).unwrap_or("a structure")
}

fn kind(name: &str) -> Kind {
    match name.trim_start_matches(['<', '>', '|']) {
        "f4" | "float32" => Kind::F32,
        "f8" | "float64" => Kind::F64,
        "b1" | "i1" | "i2" | "i4" | "i8" | "u1" | "u2" | "u4" | "u8" | "bool" => Kind::Integer,
        name if name.starts_with("int") || name.starts_with("uint") => Kind::Integer,
        _ => Kind::Other,
    }
}

/// Bytes of each text of an array of texts; 1 for texts of any length.
fn text_len(metadata: &Value) -> Option<usize> {
    let len = match type_name(metadata) {
        "|O" | "string" => Some(1),
        "null_terminated_bytes" => metadata["data_type"]["configuration"]["length_bytes"].as_u64()?.try_into().ok(),
        name => name.strip_prefix("|S")?.parse().ok(),
    };
    len.filter(|len| (1..=LONGEST_TEXT).contains(len))
}

/// The array with these metadata. Texts of fixed length, which `zarrs` has not, become raw bytes.
fn array(store: &ReadableStorage, name: &str, mut metadata: Value) -> Found<Array<dyn ReadableStorageTraits>> {
    let opened = |metadata: Value| {
        let metadata: ArrayMetadata = serde_json::from_value(metadata).map_err(|e| e.to_string())?;
        Array::new_with_metadata(store.clone(), &format!("/{name}"), metadata).map_err(|e| e.to_string())
    };
    let is_raw = type_name(&metadata).starts_with("|S") || type_name(&metadata) == "null_terminated_bytes";
    let Some(len) = text_len(&metadata).filter(|_| is_raw) else { return opened(metadata) };
    if metadata["zarr_format"] == 2 {
        (metadata["dtype"], metadata["fill_value"]) = (json!("|u1"), json!(0));
        let options = ArrayMetadataOptions::default().with_metadata_convert_version(MetadataConvertVersion::V3);
        metadata = serde_json::to_value(opened(metadata)?.metadata_opt(&options)).map_err(|e| e.to_string())?;
    }
    (metadata["data_type"], metadata["fill_value"]) = (json!(format!("r{}", 8 * len)), json!(vec![0; len]));
    // `zarrs` asks for the order of the bytes of any type of several.
    for codec in metadata["codecs"].as_array_mut().into_iter().flatten().filter(|codec| codec["name"] == "bytes") {
        codec["configuration"] = json!({"endian": "little"});
    }
    opened(metadata)
}

/// The value of an attribute; the first of several texts.
fn attribute(value: &Value) -> Option<Attribute> {
    let numbers = |values: &[Value]| {
        let is_real = values.iter().any(Value::is_f64);
        let values = values.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>()?;
        Some(Attribute::Numbers { values, is_real })
    };
    match value {
        Value::String(text) => Some(Attribute::Text(trimmed(text))),
        Value::Array(values) => match values.first()? {
            Value::String(text) => Some(Attribute::Text(trimmed(text))),
            _ => numbers(values),
        },
        one => numbers(std::slice::from_ref(one)),
    }
}

/// A mark of missing real values in words, or as xarray stores it in version 3: base64 of eight bytes.
fn real_mark(text: &str) -> Option<Attribute> {
    let value = text.parse().ok().or_else(|| {
        let bytes = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, text).ok()?;
        Some(f64::from_le_bytes(bytes.try_into().ok()?))
    })?;
    Some(Attribute::Numbers { values: vec![value], is_real: true })
}
