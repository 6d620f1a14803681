//! OSM XML (<https://wiki.openstreetmap.org/wiki/OSM_XML>).

use quick_xml::Reader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use super::extract::{Extract, OsmRelation, OsmWay, matters};
use crate::error::{MapError, MapFault, Where};
use crate::format::MapSource;
use crate::projection::checked;
use crate::rules::{Rules, Tags};

/// Reads the elements of a file.
pub fn read(source: &MapSource<'_>, rules: &Rules) -> Result<Extract, MapError> {
    let text = source.text()?;
    let mut reader = Reader::from_str(&text);
    let mut parser = Parser {
        rules,
        extract: Extract::default(),
        element: None,
        whole: false,
    };
    loop {
        let at = reader.buffer_position();
        let wrong = |fault| source.error_at(Where::in_text(&text, at as usize), fault);
        let event = reader.read_event().map_err(|error| {
            let at = reader.error_position();
            let what = error.to_string();
            source.error_at(
                Where::in_text(&text, at as usize),
                MapFault::Syntax { what },
            )
        })?;
        match event {
            Event::Start(tag) => parser.open(&tag).map_err(wrong)?,
            Event::Empty(tag) => {
                parser.open(&tag).map_err(wrong)?;
                parser.close(tag.name().as_ref()).map_err(wrong)?;
            }
            Event::End(tag) => parser.close(tag.name().as_ref()).map_err(wrong)?,
            Event::Eof => break,
            Event::Text(_)
            | Event::CData(_)
            | Event::Comment(_)
            | Event::Decl(_)
            | Event::PI(_)
            | Event::DocType(_)
            | Event::GeneralRef(_) => {}
        }
    }
    if !parser.whole {
        let what = "is not an OSM XML file, or ends before `</osm>`".to_owned();
        return Err(source.error(MapFault::Syntax { what }));
    }
    Ok(parser.extract)
}

struct Parser<'a> {
    rules: &'a Rules,
    extract: Extract,
    /// The open element, whose tags and members follow as children.
    element: Option<OsmElement>,
    /// The end of the root element was seen.
    whole: bool,
}

enum OsmElement {
    Node {
        id: i64,
        place: (f64, f64),
        tags: Tags,
    },
    Way(OsmWay),
    Relation(OsmRelation),
}

impl Parser<'_> {
    fn open(&mut self, tag: &BytesStart<'_>) -> Result<(), MapFault> {
        match tag.name().as_ref() {
            "bounds" => {
                let corner = |lon: &str, lat: &str| checked(number(tag, lon)?, number(tag, lat)?);
                self.extract.bounds =
                    Some((corner("minlon", "minlat")?, corner("maxlon", "maxlat")?));
            }
            "node" => {
                self.element = Some(OsmElement::Node {
                    id: number(tag, "id")?,
                    place: (number(tag, "lon")?, number(tag, "lat")?),
                    tags: Tags::new(),
                });
            }
            "way" => {
                self.element = Some(OsmElement::Way(OsmWay {
                    id: number(tag, "id")?,
                    nodes: Vec::new(),
                    tags: Tags::new(),
                }));
            }
            "relation" => {
                self.element = Some(OsmElement::Relation(OsmRelation {
                    ways: Vec::new(),
                    tags: Tags::new(),
                }));
            }
            "tag" => self.tag(tag)?,
            "nd" => {
                if let Some(OsmElement::Way(way)) = &mut self.element {
                    way.nodes.push(number(tag, "ref")?);
                }
            }
            "member" => {
                if let Some(OsmElement::Relation(relation)) = &mut self.element
                    && attribute(tag, "type")? == "way"
                {
                    relation.ways.push(number(tag, "ref")?);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn tag(&mut self, tag: &BytesStart<'_>) -> Result<(), MapFault> {
        let tags = match &mut self.element {
            Some(OsmElement::Node { tags, .. }) => tags,
            Some(OsmElement::Way(way)) => &mut way.tags,
            Some(OsmElement::Relation(relation)) => &mut relation.tags,
            None => return Ok(()),
        };
        let key = attribute(tag, "k")?;
        if matters(self.rules, &key) {
            tags.insert(key, attribute(tag, "v")?);
        }
        Ok(())
    }

    fn close(&mut self, name: &str) -> Result<(), MapFault> {
        self.whole |= name == "osm";
        if !matches!(name, "node" | "way" | "relation") {
            return Ok(());
        }
        match self.element.take() {
            Some(OsmElement::Node { id, place, tags }) => self.extract.add_node(id, place, tags),
            Some(OsmElement::Way(way)) => self.extract.add_way(way),
            Some(OsmElement::Relation(relation)) => self.extract.add_relation(relation),
            None => Ok(()),
        }
    }
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<String, MapFault> {
    let wrong = |what: String| MapFault::Syntax { what };
    let found = tag
        .try_get_attribute(name)
        .map_err(|error| wrong(error.to_string()))?;
    let element = tag.name();
    let found = found.ok_or_else(|| {
        wrong(format!(
            "`<{}>` has no attribute `{name}`",
            element.as_ref()
        ))
    })?;
    let value = found.normalized_value(XmlVersion::Implicit1_0);
    value
        .map(Into::into)
        .map_err(|error| wrong(error.to_string()))
}

fn number<T: std::str::FromStr>(tag: &BytesStart<'_>, name: &str) -> Result<T, MapFault> {
    let text = attribute(tag, name)?;
    text.parse().map_err(|_| MapFault::Value {
        key: name.to_owned(),
        found: format!("`{text}`"),
        expected: "a number",
    })
}
