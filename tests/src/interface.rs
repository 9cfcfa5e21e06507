//! The declarations of `icoray.h` and `icoray.f90`, read from their texts in one form, to compare them.
//!
//! The parsers read only the forms that cbindgen writes and `icoray.f90` has, and panic at others.

use std::collections::BTreeMap;

/// A declaration file in words that C and Fortran share: "i32", "i64", "size", "f64", "ptr", "text", "funptr" by value;
/// "ref" before what is passed by its address and "in" where it is only read.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Interface {
    /// Result, then arguments, by the function's name.
    pub functions: BTreeMap<String, Vec<String>>,
    /// Name and type of each member, by the struct's name.
    pub structs: BTreeMap<String, Vec<(String, String)>>,
    /// By name.
    pub constants: BTreeMap<String, i64>,
}

impl Interface {
    /// Of a C header.
    pub fn of_c(header: &str) -> Self {
        let code = without_c_comments(header);
        let mut found = Self::default();
        for line in code.lines() {
            let words: Vec<&str> = line.trim().trim_end_matches(',').split_whitespace().collect();
            match *words {
                ["#define", name, value] => found.constant(name, value),
                [name, "=", value] => found.constant(name, value),
                _ => {}
            }
        }
        let code: String = code.lines().filter(|l| !l.starts_with('#')).map(|l| format!("{l}\n")).collect();
        for block in code.split("typedef struct ").skip(1) {
            let Some((name, body)) = block.split_once('{').filter(|(name, _)| !name.contains(';')) else {
                continue;
            };
            let members = body.split_once('}').unwrap().0.split(';').map(str::trim).filter(|m| !m.is_empty());
            found.structs.insert(name.trim().into(), members.map(c_member).collect());
        }
        let functions = code.split_once("extern \"C\" {").expect("extern \"C\"").1;
        for statement in functions.split(';').filter(|s| s.contains('(')) {
            let (head, arguments) = statement.split_once('(').unwrap();
            let (name, result) = c_member(head.trim());
            let arguments = arguments.rsplit_once(')').unwrap().0.split(',').map(str::trim);
            let arguments = arguments.filter(|a| *a != "void").map(|a| c_member(a).1);
            found.functions.insert(name, [result].into_iter().chain(arguments).collect());
        }
        found
    }

    /// Of a Fortran module.
    pub fn of_fortran(module: &str) -> Self {
        let mut found = Self::default();
        let mut scope = None;
        for statement in fortran_statements(module) {
            if let Some(name) = statement.strip_prefix("type, bind(c), public :: ") {
                found.structs.insert(name.into(), Vec::new());
                scope = Some(Scope::Struct(name.into()));
            } else if let Some(function) = Function::start(&statement) {
                scope = Some(Scope::Function(function));
            } else if statement.starts_with("end ") {
                if let Some(Scope::Function(f)) = scope.take() {
                    found.functions.insert(f.c_name, f.types);
                }
            } else if let Some((spec, entities)) = statement.split_once(" :: ") {
                for entity in top_level(entities, ',') {
                    let (name, value) = entity.split_once('=').map_or((entity, ""), |(n, v)| (n, v));
                    let (name, shape) = name.trim().split_once('(').unwrap_or((name.trim(), ""));
                    let shape = shape.trim_end_matches(')');
                    match &mut scope {
                        Some(Scope::Struct(of)) => {
                            let extent = if shape.is_empty() { String::new() } else { format!("[{shape}]") };
                            let kind = fortran_type(&format!("{spec}, value"), "") + &extent;
                            found.structs.get_mut(of).unwrap().push((name.into(), kind));
                        }
                        Some(Scope::Function(f)) => f.declare(name, &fortran_type(spec, shape)),
                        None if spec.contains("parameter") && name.starts_with("icoray_") => {
                            found.constant(&name.to_uppercase(), value.trim());
                        }
                        None => {}
                    }
                }
            }
        }
        found
    }

    fn constant(&mut self, name: &str, value: &str) {
        if name.starts_with("ICORAY_") && name != "ICORAY_H" {
            self.constants.insert(name.into(), value.parse().unwrap_or_else(|e| panic!("{name} {value}: {e}")));
        }
    }

    /// Items of a C header that a Fortran module lacks or has in another form, and superfluous items there.
    pub fn differences(&self, fortran: &Self) -> Vec<String> {
        // A plain address may stand for that of a string or of what is only read.
        let fits = |c: &str, f: &str| c == f || (f == "ptr" && (c == "in text" || c.starts_with("in ref ")));
        let mut differences = Vec::new();
        compare(&mut differences, &self.functions, &fortran.functions, |c, f| {
            c.len() == f.len() && c.iter().zip(f).all(|(c, f)| fits(c, f))
        });
        compare(&mut differences, &self.structs, &fortran.structs, |c, f| {
            c.len() == f.len() && c.iter().zip(f).all(|(c, f)| c.0 == f.0 && fits(&c.1, &f.1))
        });
        compare(&mut differences, &self.constants, &fortran.constants, PartialEq::eq);
        differences
    }
}

fn compare<T: std::fmt::Debug>(
    differences: &mut Vec<String>,
    ours: &BTreeMap<String, T>,
    theirs: &BTreeMap<String, T>,
    same: impl Fn(&T, &T) -> bool,
) {
    for (name, a) in ours {
        match theirs.get(name) {
            None => differences.push(format!("{name}: missing")),
            Some(b) if !same(a, b) => differences.push(format!("{name}: {a:?} and {b:?}")),
            Some(_) => {}
        }
    }
    differences.extend(theirs.keys().filter(|name| !ours.contains_key(*name)).map(|name| format!("{name}: too much")));
}

/// Where a Fortran declaration stands.
enum Scope {
    Struct(String),
    Function(Function),
}

struct Function {
    c_name: String,
    /// The result's name, then the arguments'.
    names: Vec<String>,
    types: Vec<String>,
}

impl Function {
    fn start(statement: &str) -> Option<Self> {
        let (head, binding) = statement.split_once(" bind(c, name='")?;
        let c_name = binding.split_once('\'').filter(|(name, _)| name.starts_with("icoray_"))?.0;
        let result = binding.split_once("result(").map_or("", |(_, r)| r.trim_end_matches(')'));
        let arguments = head.split_once('(')?.1.trim_end_matches(')').split(',').map(str::trim);
        let names: Vec<String> =
            [result].into_iter().chain(arguments.filter(|a| !a.is_empty())).map(String::from).collect();
        let mut types = vec!["undeclared".to_string(); names.len()];
        if result.is_empty() {
            types[0] = "void".into();
        }
        Some(Function { c_name: c_name.into(), names, types })
    }

    fn declare(&mut self, name: &str, kind: &str) {
        match self.names.iter().position(|n| n == name) {
            // A result has neither value nor an address.
            Some(0) => self.types[0] = kind.trim_start_matches("ref ").into(),
            Some(place) => self.types[place] = kind.into(),
            None => self.types.push(format!("{name}, which is no argument")),
        }
    }
}

fn fortran_type(spec: &str, shape: &str) -> String {
    let mut parts = top_level(spec, ',').into_iter();
    let base = match parts.next().unwrap() {
        "integer(c_int32_t)" => "i32",
        "integer(c_int64_t)" => "i64",
        "integer(c_size_t)" => "size",
        "real(c_double)" => "f64",
        "type(c_ptr)" => "ptr",
        "type(c_funptr)" => "funptr",
        "character(kind=c_char)" => "text",
        other => other.strip_prefix("type(").unwrap_or(other).trim_end_matches(')'),
    };
    let attributes: Vec<&str> = parts.collect();
    let read = if attributes.contains(&"intent(in)") { "in " } else { "" };
    match (base, shape) {
        ("text", "*") => format!("{read}text"),
        _ if attributes.contains(&"value") => base.into(),
        _ => format!("{read}ref {base}"),
    }
}

/// Name and type of a C member, argument or function.
fn c_member(declaration: &str) -> (String, String) {
    let at = declaration.rfind([' ', '*']).unwrap();
    let (spec, name) = (declaration[..=at].trim(), declaration[at + 1..].to_lowercase());
    let (name, extent) = name.split_once('[').map_or((name.as_str(), ""), |(n, e)| (n, e));
    let stars = spec.matches('*').count();
    let words: Vec<&str> = spec.trim_end_matches(['*', ' ']).split_whitespace().collect();
    let read = if words.contains(&"const") { "in " } else { "" };
    let opaque = |name: &str| ["void", "icoray_ctx", "icoray_mesh"].contains(&name);
    let base = match *words.last().unwrap() {
        "int32_t" | "icoray_status" => "i32",
        "int64_t" | "uint64_t" => "i64",
        "size_t" => "size",
        "double" => "f64",
        "icoray_log_fn" => "funptr",
        other => other,
    };
    let kind = match (base, stars) {
        (_, 0) => base.into(),
        ("char", 1) => format!("{read}text"),
        (base, 1) if opaque(base) => "ptr".into(),
        (base, 2) if opaque(base) => "ref ptr".into(),
        (base, 1) => format!("{read}ref {base}"),
        _ => panic!("{declaration}"),
    };
    let kind = if extent.is_empty() { kind } else { format!("{kind}[{}", extent.to_lowercase()) };
    (name.into(), kind)
}

fn without_c_comments(text: &str) -> String {
    let mut pieces = text.split("/*");
    let mut code = pieces.next().unwrap().to_string();
    for piece in pieces {
        code.push_str(piece.split_once("*/").expect("a comment that ends").1);
    }
    code.lines().map(|line| line.split("//").next().unwrap().to_string() + "\n").collect()
}

/// Statements in lower case, without comments, each on one line.
fn fortran_statements(text: &str) -> Vec<String> {
    let mut statements = Vec::new();
    let mut statement = String::new();
    for line in text.lines() {
        let mut quoted = false;
        let code = line.split(|c| {
            quoted ^= c == '\'';
            c == '!' && !quoted
        });
        let code = code.into_iter().next().unwrap().trim();
        let (code, goes_on) = code.strip_suffix('&').map_or((code, false), |c| (c, true));
        statement.push_str(&code.to_lowercase());
        if !goes_on && !statement.is_empty() {
            statements.push(std::mem::take(&mut statement));
        }
    }
    statements
}

/// Splits where no bracket is open.
fn top_level(text: &str, at: char) -> Vec<&str> {
    let mut depth = 0;
    let split = text.split(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == at && depth == 0
    });
    split.map(str::trim).collect()
}
