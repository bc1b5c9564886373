//! The page: sections, numbered figures and tables in one self-contained file.

use std::io::Write;
use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::figure::{Figure, Rich};

/// The colours and the parts that all pages have: tiles, checks, tables, figures, remarks.
pub const COMPONENTS: &str = include_str!("components.css");

/// A finished report: one HTML file, and each of its figures as a separate file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Document {
    /// The self-contained page.
    pub html: String,
    /// Names and contents of the figures.
    pub figures: Vec<(String, String)>,
    /// What stands below each figure, as plain text.
    pub captions: Vec<String>,
}

impl Document {
    /// Writes `report.html` and the folder `figures`; each file is written under a temporary name and then renamed.
    ///
    /// # Errors
    /// If a file cannot be written; the message names the file.
    pub fn write(&self, folder: &Path) -> granum_io::Result<()> {
        let write = |path: &Path, text: &str| {
            granum_io::atomic::write_atomically(path, |file| file.write_all(text.as_bytes()))
        };
        let figures = granum_io::inner_folder(folder, "figures")?;
        if !self.figures.is_empty() {
            granum_io::figure_list::add(&figures, self.figures.iter().map(|(name, _)| name.as_str()))?;
        }
        for (name, svg) in &self.figures {
            write(&figures.join(name), svg)?;
        }
        write(&folder.join("report.html"), &self.html)
    }
}

/// A page that is being written.
#[derive(Debug, Default)]
pub struct Page {
    sections: Vec<Section>,
    files: Vec<(String, String)>,
    captions: Vec<String>,
    figures: usize,
    tables: usize,
}

#[derive(Debug)]
struct Section {
    id: String,
    title: String,
    body: Markup,
}

/// Marked-up text as HTML.
pub fn rich(markup: &str) -> Markup {
    PreEscaped(Rich::new(markup).html())
}

/// Paragraphs of marked-up text.
pub fn paragraphs<S: AsRef<str>>(texts: &[S]) -> Markup {
    html! { @for text in texts { p { (rich(text.as_ref())) } } }
}

impl Page {
    /// Adds a section.
    pub fn section(&mut self, id: &str, title: &str, body: Markup) {
        self.sections.push(Section { id: id.to_owned(), title: title.to_owned(), body });
    }

    /// Adds a figure with the same label as in the paper, e.g. `Figure 3`.
    pub fn figure(&mut self, label: &str, file: &str, caption: &str, figure: &Figure) -> Markup {
        self.files.push((file.to_owned(), figure.to_svg()));
        self.captions.push(format!("{label}. {}", Rich::new(caption).plain()));
        html! {
            figure {
                div class="canvas" { (PreEscaped(figure.to_inline_svg())) }
                figcaption { b { (label) "." } " " (rich(caption)) }
            }
        }
    }

    /// Adds a figure that the paper does not contain: `Figure S1`, `Figure S2`...
    pub fn own_figure(&mut self, file: &str, caption: &str, figure: &Figure) -> Markup {
        self.figures += 1;
        let label = format!("Figure S{}", self.figures);
        self.figure(&label, &format!("figure-s{}-{file}.svg", self.figures), caption, figure)
    }

    /// The label of the next table that the paper does not contain: `Table S1`...
    pub fn own_table_label(&mut self) -> String {
        self.tables += 1;
        format!("Table S{}", self.tables)
    }

    /// A table that the paper does not contain, with the label that is its turn.
    pub fn own_table(&mut self, table: PageTable) -> Markup {
        PageTable { label: self.own_table_label(), ..table }.html()
    }

    /// The page in one file.
    pub fn finish(self, title: &str, subtitle: &str, head: Markup) -> Document {
        let markup = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content="granum";
                    title { (Rich::new(title).plain()) }
                    style { (PreEscaped(COMPONENTS)) (PreEscaped(include_str!("style.css"))) }
                }
                body {
                    nav {
                        p class="brand" { "granum" }
                        ol { @for section in &self.sections {
                            li { a href={ "#" (section.id) } { (section.title) } }
                        } }
                    }
                    main {
                        header {
                            h1 { (rich(title)) }
                            p class="subtitle" { (rich(subtitle)) }
                        }
                        (head)
                        @for section in &self.sections {
                            section id=(section.id) {
                                h2 { (section.title) }
                                (section.body)
                            }
                        }
                    }
                }
            }
        };
        Document { html: markup.into_string(), figures: self.files, captions: self.captions }
    }
}

/// A table: a caption, columns and rows of marked-up text.
#[derive(Clone, Debug, Default)]
pub struct PageTable {
    /// Label, e.g. `Table 1`.
    pub label: String,
    /// Caption.
    pub caption: String,
    /// Headings of groups of columns with the number of columns of each; empty if there are no groups.
    pub groups: Vec<(String, usize)>,
    /// Headings of columns.
    pub columns: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
    /// Number of columns at the left that contain text.
    pub words: usize,
    /// Note below the table.
    pub note: String,
}

impl PageTable {
    /// A table with a caption and columns, the first of which contains text.
    pub fn new(label: &str, caption: &str, columns: &[&str]) -> Self {
        PageTable {
            label: label.to_owned(),
            caption: caption.to_owned(),
            columns: columns.iter().map(|&column| column.to_owned()).collect(),
            words: 1,
            ..PageTable::default()
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The table as HTML.
    pub fn html(&self) -> Markup {
        html! {
            // A table that is wider than its page scrolls, with the keyboard as well.
            div class="scroll" tabindex="0" role="region" aria-label=(self.label) {
                table {
                    caption { b { (self.label) "." } " " (rich(&self.caption)) }
                    thead {
                        @if !self.groups.is_empty() {
                            tr class="groups" { @for (head, span) in &self.groups {
                                th colspan=(span) class=[(!head.is_empty()).then_some("group")] { (rich(head)) }
                            } }
                        }
                        tr { @for (k, head) in self.columns.iter().enumerate() {
                            th class=[(k < self.words).then_some("word")] { (rich(head)) }
                        } }
                    }
                    tbody { @for row in &self.rows {
                        tr { @for (k, cell) in row.iter().enumerate() {
                            td class=[(k < self.words).then_some("word")] { (rich(cell)) }
                        } }
                    } }
                }
                @if !self.note.is_empty() { p class="note" { (rich(&self.note)) } }
            }
        }
    }
}

/// A statement that is passed or missed; all but the advice is marked-up text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// True if it is passed.
    pub passed: bool,
    /// What is judged.
    pub name: String,
    /// What stands before the value.
    pub before: String,
    /// Its value.
    pub value: String,
    /// What stands after the value: the limit.
    pub after: String,
    /// What to do, where it is missed.
    pub advice: String,
}

/// The main numbers side by side, each with its value, its name and a remark of one line.
pub fn tiles(tiles: &[[String; 3]]) -> Markup {
    html! {
        ul class="tiles" { @for [value, name, remark] in tiles {
            li class="tile" {
                b { (rich(value)) }
                span { (rich(name)) }
                @if !remark.is_empty() { small { (rich(remark)) } }
            }
        } }
    }
}

/// Statements that are passed or missed, each with what to do if it is missed.
pub fn checks(checks: &[Check]) -> Markup {
    html! {
        ul class="checks" { @for check in checks {
            li class=(if check.passed { "passed" } else { "missed" }) {
                (rich(&check.name)) ": " (rich(&check.before)) b { (rich(&check.value)) } (rich(&check.after))
                @if !check.advice.is_empty() { " What to do: " span class="advice" { (check.advice) "." } }
            }
        } }
    }
}
