//! The report's page: whole, self-contained, with a mark for each point that has a place and a sentence for each that
//! has none.

mod browser;
mod sample;

use std::collections::BTreeSet;

use scraper::{ElementRef, Html, Selector};
use texray::report::Report;

fn count(page: &Html, selector: &str) -> usize {
    page.select(&of(selector)).count()
}

fn of(selector: &str) -> Selector {
    Selector::parse(selector).expect("a selector")
}

fn text(element: ElementRef) -> String {
    element.text().collect()
}

fn page(report: &Report) -> (String, Html) {
    let html = report.to_html();
    let page = Html::parse_document(&html);
    assert_eq!(page.errors, Vec::<std::borrow::Cow<str>>::new(), "a parser of HTML5 has nothing to complain about");
    (html, page)
}

#[test]
fn marks_are_points() {
    let (_, page) = page(&sample::report());
    assert_eq!(count(&page, ".chart .mark"), sample::POINTS);
    assert_eq!(count(&page, ".bars rect.mark"), sample::BARS);
    assert_eq!(count(&page, ".tile img"), sample::PICTURES);
    assert_eq!(count(&page, ".band"), 2, "one a fit");
    // Six points a fitted series, each with an interval, and one more; three bars.
    assert_eq!(count(&page, ".chart path.whisker"), 13);
    assert_eq!(count(&page, ".bars path.whisker"), 3);
    // Every mark has a tip, and every place is a number inside its drawing.
    assert_eq!(count(&page, ".mark > title"), sample::POINTS + sample::BARS);
    for path in page.select(&of(".chart > svg path")) {
        let d = path.value().attr("d").expect("a path has places");
        let numbers = d.split(|c: char| c.is_ascii_alphabetic() || c == ' ').filter(|part| !part.is_empty());
        for number in numbers {
            let place: f64 = number.parse().unwrap_or_else(|_| panic!("{number:?} in {d}"));
            assert!((-20.0..=560.0).contains(&place), "{place} in {d}");
        }
    }
}

#[test]
fn a_fit_is_told_with_its_interval() {
    let (_, page) = page(&sample::report());
    let fits: Vec<String> = page.select(&of(".fit")).map(text).collect();
    assert_eq!(fits.len(), 2);
    assert!(fits[0].starts_with(": slope −0.50") && fits[0].contains("95 %: −0.5"), "{fits:?}");
}

#[test]
fn the_page_opens_with_what_was_found() {
    let (html, page) = page(&sample::report());
    assert_eq!(
        page.select(&of("header .opening li")).map(text).collect::<Vec<_>>(),
        ["One.", "Two.", "Three.", "Four.", "Five."]
    );
    assert!(html.find("Five.") < html.find("<dl") && html.find("Five.") < html.find("<nav"));
}

/// The default is named in the legend and drawn after every other series, so that none hides it.
#[test]
fn the_default_is_marked_and_not_hidden() {
    let (_, page) = page(&sample::report());
    assert_eq!(count(&page, ".chart .legend li.default"), 1);
    let legend: Vec<String> = page.select(&of(".legend li.default")).map(text).collect();
    assert!(legend[0].starts_with("Sobol' (the default)"), "{legend:?}");
    let chart = page.select(&of("figure.chart > svg")).next().expect("a chart");
    let series: Vec<bool> =
        chart.select(&of("g.series")).map(|g| g.value().classes().any(|c| c == "default")).collect();
    assert_eq!(series, [false, true]);
    assert_eq!(count(&page, ".bars rect.mark.default"), 1);
    assert!(page.select(&of(".bars text.name")).map(text).any(|name| name == "padded boxes (the default)"));
}

/// A point whose repeats differ tenfold has a ring, a bar a sentence; all have one that says what they differ by.
#[test]
fn repeats_that_disagree_are_flagged() {
    let (_, page) = page(&sample::report());
    assert_eq!(count(&page, ".chart circle.doubt"), 1);
    let gaps: Vec<String> = page.select(&of(".gap")).map(text).collect();
    for sentence in [
        "cornell-box: the repeats of a ringed point differ by 10 times or more: 0.0200 to 0.200 at 2.00.",
        "padded boxes: its repeats differ by 10 times or more: 0.100 to 1.50.",
    ] {
        assert!(gaps.iter().any(|gap| gap == sentence), "{sentence:?} in {gaps:#?}");
    }
}

/// Axes have numbers from end to end, those of bars too, and the name of the vertical one stands above the numbers.
#[test]
fn axes_are_numbered_over_their_whole_length() {
    let (_, page) = page(&sample::report());
    let place = |element: &ElementRef, name: &str| -> f64 {
        element.value().attr(name).and_then(|place| place.parse().ok()).expect("a place")
    };
    let mut drawings = 0;
    for drawing in page.select(&of("figure > svg")) {
        drawings += 1;
        let is_bars = drawing.select(&of("rect.mark")).next().is_some();
        let numbers: Vec<ElementRef> = drawing.select(&of(".axis text:not(.name)")).collect();
        let along: Vec<f64> = numbers
            .iter()
            .filter(|number| number.value().attr("text-anchor") == Some("middle") && !text(**number).is_empty())
            .map(|number| place(number, "x"))
            .collect();
        let (first, last) = if is_bars { (22.0, 440.0) } else { (78.0, 528.0) };
        let ends = [along[0] - first, last - along[along.len() - 1]];
        assert!(ends.iter().all(|end| (-0.01..100.0).contains(end)), "{along:?}");
        // Letters of 18 units, some 11 wide each, do not meet.
        assert!(along.windows(2).all(|pair| pair[1] - pair[0] > 40.0), "{along:?}");
        for name in drawing.select(&of(".axis text.name")) {
            assert_eq!(name.value().attr("transform"), None, "it would stand on the numbers");
        }
    }
    assert_eq!(drawings, 3);
}

#[test]
fn pictures_stand_at_their_own_size() {
    let (html, page) = page(&sample::report());
    for tile in page.select(&of(".tile")).filter(|tile| tile.select(&of("img")).next().is_some()) {
        assert_eq!(tile.value().attr("style"), Some("width: 96px"));
    }
    assert!(html.contains(".tile img { display: block; max-width: 100%; height: auto;"));
}

#[test]
fn gaps_are_stated() {
    let (_, page) = page(&sample::report());
    let gaps: Vec<String> = page.select(&of(".gap")).map(text).collect();
    for sentence in [
        "glass: 1 of 6 points cannot be drawn, as they are not finite: (8.00, not a number).",
        "not a number: no bar",
        "No figures to draw.",
        "empty: no figures.",
        "all zero: 7 of 7 points cannot be drawn, as they are not finite or not above 0: (1.00, 0), (1.00, 0), (1.00, 0), \
         (1.00, 0), (1.00, 0), ….",
        "No rows.",
        "No pictures.",
        " 1 pixel is not finite",
        " 1 pixel is not finite (not-a-numbers show black)",
    ] {
        assert!(gaps.iter().any(|gap| gap == sentence), "{sentence:?} in {gaps:#?}");
    }
    let empty = Report::default();
    assert!(empty.to_html().contains("Nothing was measured."));
}

#[test]
fn anchors_are_unique_and_labels_exist() {
    let (_, page) = page(&sample::report());
    let ids: Vec<&str> = page.select(&of("[id]")).filter_map(|element| element.value().attr("id")).collect();
    let unique: BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), unique.len(), "{ids:?}");
    for attribute in ["aria-labelledby", "href"] {
        for element in page.select(&of(&format!("[{attribute}]"))) {
            let target = element.value().attr(attribute).expect("it was selected for it");
            assert!(target == "data:," || unique.contains(target.trim_start_matches('#')), "{attribute} {target}");
        }
    }
    assert_eq!(count(&page, "nav a"), 5);
    for image in page.select(&of("img")) {
        assert!(image.value().attr("alt").is_some_and(|alt| !alt.is_empty()));
    }
    assert_eq!(count(&page, "svg[role=img]"), count(&page, "svg[role=img] > title"));
    assert_eq!(count(&page, "figure.chart details table tbody tr"), 21 + 7, "every point is in a table");
}

#[test]
fn the_page_needs_nothing_else() {
    let (html, page) = page(&sample::report());
    for words in ["http:", "https:", "//cdn", "@import", "url(", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!html.contains(words), "{words}");
    }
    for element in page.select(&of("[src], link")) {
        let value = element.value().attr("src").or(element.value().attr("href")).unwrap_or_default();
        assert!(value.starts_with("data:"), "{value:.60}");
    }
    assert!(html.contains("default-src 'none'"), "a browser refuses what the page should not ask for");
}

#[test]
fn text_is_text() {
    let (_, page) = page(&sample::report());
    assert_eq!(page.select(&of("h1")).map(text).collect::<String>(), "Error <against> time & \"more\"");
    assert!(page.select(&of("p")).map(text).any(|text| text == "A paragraph with <b>markup</b> in it."));
    assert_eq!(count(&page, "b"), 0);
    let commands: Vec<String> = page.select(&of(".command")).map(text).collect();
    assert_eq!(commands[0], "texray study convergence scenes/cornell-box.toml --out DIR");
    assert_eq!(commands.len(), 5);
    let cells: Vec<String> = page.select(&of("#effects td")).map(text).collect();
    assert_eq!(cells, ["cornell-box", "1.87", "38", "dragon", "0.50", "–", "room", "–", "–"]);
}

#[test]
fn pictures_are_what_was_given() {
    use base64::Engine;
    let (_, page) = page(&sample::report());
    let images: Vec<_> = page.select(&of(".tile img")).collect();
    let decoded: Vec<image::RgbImage> = images
        .iter()
        .map(|element| {
            let source = element.value().attr("src").and_then(|src| src.strip_prefix("data:image/png;base64,"));
            let bytes = base64::engine::general_purpose::STANDARD.decode(source.expect("PNG")).expect("base64");
            image::load_from_memory(&bytes).expect("a PNG").to_rgb8()
        })
        .collect();
    assert!(decoded.iter().all(|image| image.dimensions() == (96, 72)));
    // Half of the row is 0.5 in linear light: 188 of 255 in sRGB, within a step of the gradient.
    assert!(decoded[0].get_pixel(48, 10).0[0].abs_diff(188) <= 2);
    assert_eq!(decoded[2].get_pixel(40, 0).0[0], 0, "not a number shows black");
    assert_eq!(decoded[4].get_pixel(40, 0).0, [255, 0, 255], "and magenta in the difference");
}

#[test]
fn equal_reports_are_equal_pages() {
    assert_eq!(sample::report().to_html(), sample::report().to_html());
}
