//! The pages that explain a code at length: what it means, a program that gives it, and the way out.
//!
//! A page is a file of its own, `words/pages/E0301.md`: a title, paragraphs, and programs that are indented by four spaces: the first
//! gives the code, the second is mended.

/// What there is to say about a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// The code.
    pub code: &'static str,
    /// All of it, with a title in its first line, as [`Page::title`] gives it without marks.
    pub text: &'static str,
}

impl Page {
    /// What the code means in a few words.
    pub fn title(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or("");
        first.split_once(": ").map_or(first, |it| it.1)
    }
}

/// The page of a code. Capitals do not matter.
pub fn explain(code: &str) -> Option<&'static Page> {
    PAGES.iter().find(|it| it.code.eq_ignore_ascii_case(code))
}

/// All pages in the order of their codes.
pub fn pages() -> &'static [Page] {
    PAGES
}

macro_rules! pages {
    ($($code:literal)*) => {
        &[$(Page { code: $code, text: include_str!(concat!("words/pages/", $code, ".md")) }),*]
    };
}

#[rustfmt::skip]
const PAGES: &[Page] = pages![
    "E0101" "E0102" "E0103" "E0104" "E0105" "E0106" "E0107" "E0108" "E0109"
    "E0110" "E0111" "E0112" "E0113" "E0114" "E0115"
    "E0201" "E0202" "E0203" "E0204" "E0205" "E0206" "E0207" "E0208"
    "E0301" "E0302" "E0303" "E0304" "E0305" "E0306" "E0307" "E0308" "E0309"
    "E0310" "E0311"
    "E0401" "E0402" "E0403" "E0404" "E0405" "E0406" "E0407"
    "E0411" "E0412" "E0413" "E0414" "E0415" "E0416" "E0417" "E0418" "E0419"
    "E0420"
    "E0501" "E0502" "E0503" "E0504" "E0505" "E0506" "E0507" "E0508" "E0509"
    "E0510" "E0511" "E0512" "E0513" "E0514" "E0515" "E0516" "E0517" "E0518" "E0519"
    "E0601" "E0602" "E0603" "E0604" "E0605" "E0606" "E0607" "E0608" "E0609"
    "E0610" "E0611" "E0612" "E0613"
    "E0621" "E0622"
    "E0701"
    "E0801" "E0802" "E0803"
    "E0901" "E0902" "E0903" "E0904" "E0905" "E0906" "E0907" "E0908" "E0909" "E0910"
    "E0911" "E0912" "E0913" "E0914" "E0915" "E0916" "E0917" "E0918" "E0919"
    "E0920" "E0921" "E0922" "E0923" "E0924" "E0925" "E0926" "E0927" "E0928" "E0929" "E0930"
    "E0999"
    "E1001" "E1002" "E1003" "E1004" "E1005" "E1006" "E1007" "E1008" "E1009"
    "E1010" "E1011" "E1012" "E1013" "E1014" "E1015" "E1016" "E1017" "E1018"
    "W0001" "W0002" "W0003" "W0004" "W0005" "W0006" "W0007" "W0008" "W0009"
    "W0010" "W0011" "W0012"
];
