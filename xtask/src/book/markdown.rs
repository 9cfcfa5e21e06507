//! Parses the parts of a Markdown page that are checked: links, headings and fenced code.

#[derive(Debug, Default, PartialEq)]
pub struct Page {
    /// Its path below the workspace's root, with `/`.
    pub path: String,
    /// Targets of links and images outside code.
    pub links: Vec<Link>,
    pub anchors: Vec<String>,
    pub fences: Vec<Fence>,
    /// Lines of code that is indented instead of fenced.
    pub indented: Vec<usize>,
}

#[derive(Debug, PartialEq)]
pub struct Link {
    /// Its line, from 1.
    pub line: usize,
    pub target: String,
}

#[derive(Debug, PartialEq)]
pub struct Fence {
    /// The line of the opening fence, from 1.
    pub line: usize,
    /// The first word of the info string.
    pub language: String,
    /// The other words.
    pub attributes: Vec<String>,
    /// The file named by a comment `<!-- from FILE -->` on the line above.
    pub source: Option<String>,
    pub text: String,
}

impl Page {
    /// Parses the text of the page at `path`.
    pub fn parse(path: &str, text: &str) -> Page {
        let mut page = Page { path: path.into(), ..Page::default() };
        let mut lines = text.lines().enumerate();
        let mut previous = "";
        while let Some((number, line)) = lines.next() {
            if let Some(info) = line.strip_prefix("```") {
                let mut words = info.split_whitespace().map(str::to_owned);
                let code: Vec<&str> = lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```").collect();
                page.fences.push(Fence {
                    line: number + 1,
                    language: words.next().unwrap_or_default(),
                    attributes: words.collect(),
                    source: source(previous),
                    text: code.iter().map(|line| format!("{line}\n")).collect(),
                });
            } else if let Some(heading) = line.strip_prefix('#') {
                let anchor = page.distinct(anchor(heading.trim_start_matches('#')));
                page.anchors.push(anchor);
            } else if line.starts_with("    ") && previous.is_empty() {
                page.indented.push(number + 1);
            } else {
                let targets = targets(line).into_iter();
                page.links.extend(targets.map(|target| Link { line: number + 1, target }));
            }
            previous = line;
        }
        page
    }

    /// The anchor, with a number if another heading has it already.
    fn distinct(&self, anchor: String) -> String {
        let numbered = (1..).map(|number| format!("{anchor}-{number}"));
        let mut candidates = std::iter::once(anchor.clone()).chain(numbered);
        candidates.find(|candidate| !self.anchors.contains(candidate)).unwrap_or(anchor)
    }
}

/// The file that a line `<!-- from FILE -->` names.
fn source(line: &str) -> Option<String> {
    Some(line.strip_prefix("<!-- from ")?.strip_suffix(" -->")?.to_owned())
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// The targets of the links in a line, outside code between backticks.
fn targets(line: &str) -> Vec<String> {
    let prose: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
    let starts = prose.split("](").skip(1);
    starts.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target.to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_headings_and_code_are_found() {
        let text = "# A `b`, c!\nSee [x](y.md#z) and ![p](q.png), not `[i](j)`.\n\
                    <!-- from a.c -->\n```c slow needs=mpi\nint i;\n[k](l)\n```\n\n    code\n## A b c\n";
        let page = Page::parse("p.md", text);
        assert_eq!(page.anchors, ["a-b-c", "a-b-c-1"]);
        let targets: Vec<_> = page.links.iter().map(|l| (l.line, l.target.as_str())).collect();
        assert_eq!(targets, [(2, "y.md#z"), (2, "q.png")]);
        let [fence] = &page.fences[..] else { panic!("{page:?}") };
        assert_eq!((fence.line, fence.language.as_str()), (4, "c"));
        assert_eq!(fence.attributes, ["slow", "needs=mpi"]);
        assert_eq!(fence.source.as_deref(), Some("a.c"));
        assert_eq!(fence.text, "int i;\n[k](l)\n");
        assert_eq!(page.indented, [9]);
    }
}
