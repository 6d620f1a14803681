//! OSM PBF (<https://wiki.openstreetmap.org/wiki/PBF_Format>): a sequence of separately compressed blocks, each a
//! protobuf message. Field numbers are those of `fileformat.proto` and `osmformat.proto`.

use flate2::read::ZlibDecoder;

use super::extract::{Extract, OsmRelation, OsmWay, matters};
use super::wire::{ProtobufError, ProtobufField, ProtobufNumbers, fields};
use crate::error::{MapError, MapFault};
use crate::files::read_at_most;
use crate::format::MapSource;
use crate::map::LonLat;
use crate::projection::checked;
use crate::rules::{Rules, Tags};

/// Limit on the size of a block's header in bytes, from the specification.
const MAX_HEADER: usize = 64 << 10;

/// Limit on the size of a block in bytes after decompression, from the specification.
const MAX_BLOCK: u64 = 32 << 20;

/// Reads the elements of a file.
pub fn read(source: &MapSource<'_>, rules: &Rules) -> Result<Extract, MapError> {
    let bytes = source.bytes()?;
    blocks(&bytes, rules).map_err(|fault| source.error(fault))
}

fn blocks(bytes: &[u8], rules: &Rules) -> Result<Extract, MapFault> {
    let mut extract = Extract::default();
    let mut has_header = false;
    let mut rest = bytes;
    while !rest.is_empty() {
        let length = take(&mut rest, 4)?.iter();
        let length = length.fold(0, |length, byte| length << 8 | usize::from(*byte));
        if length > MAX_HEADER {
            return Err(syntax(
                "is not an OSM PBF file, or damaged: a block's header is too long",
            ));
        }
        let (kind, length) = blob_header(take(&mut rest, length)?)?;
        let blob = take(&mut rest, length)?;
        match kind {
            b"OSMHeader" => {
                has_header = true;
                extract.bounds = extract.bounds.or(bounds(&unpack(blob)?)?);
            }
            b"OSMData" => add_block(&mut extract, &unpack(blob)?, rules)?,
            // unknown blocks must be skipped, by the specification
            _ => {}
        }
    }
    if !has_header {
        return Err(syntax("is not an OSM PBF file: it has no header block"));
    }
    Ok(extract)
}

fn take<'a>(rest: &mut &'a [u8], length: usize) -> Result<&'a [u8], MapFault> {
    let cut = || syntax("ends in the middle of a block");
    let (taken, after) = rest.split_at_checked(length).ok_or_else(cut)?;
    *rest = after;
    Ok(taken)
}

fn syntax(what: impl ToString) -> MapFault {
    MapFault::Syntax {
        what: what.to_string(),
    }
}

impl From<ProtobufError> for MapFault {
    fn from(error: ProtobufError) -> Self {
        syntax(format_args!("a block is damaged: {error}"))
    }
}

/// Returns a field that the schema requires, or an error if it is missing.
fn required<T>(found: Option<T>, what: &str) -> Result<T, MapFault> {
    found.ok_or_else(|| syntax(format_args!("a block is damaged: {what} is missing")))
}

/// The type of the following block, and its size in bytes.
fn blob_header(message: &[u8]) -> Result<(&[u8], usize), MapFault> {
    let (mut kind, mut length) = (None, None);
    for field in fields(message) {
        let field = field?;
        match field.number {
            1 => kind = Some(field.bytes()?),
            3 => length = usize::try_from(field.int()?).ok(),
            _ => {}
        }
    }
    let kind = required(kind, "its type")?;
    Ok((kind, required(length, "its size")?))
}

/// Decompresses the message in a block.
fn unpack(blob: &[u8]) -> Result<Vec<u8>, MapFault> {
    for field in fields(blob) {
        let field = field?;
        let read = match field.number {
            1 => read_at_most(field.bytes()?, MAX_BLOCK),
            3 => read_at_most(ZlibDecoder::new(field.bytes()?), MAX_BLOCK),
            4..=7 => {
                return Err(syntax(
                    "has a compression other than zlib; `osmium cat` writes a file with zlib",
                ));
            }
            _ => continue,
        };
        return read.map_err(|fault| syntax(format_args!("a block cannot be unpacked: {fault}")));
    }
    Err(syntax("a block is empty"))
}

/// The bounds in the header block, if any; encoded in nanodegrees.
fn bounds(header: &[u8]) -> Result<Option<(LonLat, LonLat)>, MapFault> {
    let mut found = None;
    for field in fields(header) {
        let field = field?;
        if field.number == 1 {
            found = Some(corners(field.bytes()?)?);
        }
    }
    Ok(found)
}

fn corners(message: &[u8]) -> Result<(LonLat, LonLat), MapFault> {
    let mut sides = [None; 4];
    for field in fields(message) {
        let field = field?;
        if let number @ 1..=4 = field.number {
            sides[number as usize - 1] = Some(field.sint()? as f64 * 1e-9);
        }
    }
    let [left, right, top, bottom] = sides;
    let side = |degrees| required(degrees, "a side of the bounding box");
    let low = checked(side(left)?, side(bottom)?)?;
    let high = checked(side(right)?, side(top)?)?;
    Ok((low, high))
}

/// The data shared by all elements of a block.
struct Block<'a> {
    /// Keys and values of tags, by index; index 0 is a delimiter.
    strings: Vec<&'a [u8]>,
    /// Unit of coordinates, nanodegrees.
    granularity: i64,
    /// Offset of longitudes, nanodegrees.
    longitude_offset: i64,
    /// Offset of latitudes, nanodegrees.
    latitude_offset: i64,
    rules: &'a Rules,
}

fn add_block(extract: &mut Extract, message: &[u8], rules: &Rules) -> Result<(), MapFault> {
    let mut block = Block {
        strings: Vec::new(),
        granularity: 100,
        longitude_offset: 0,
        latitude_offset: 0,
        rules,
    };
    // the numbers needed to decode the groups follow them
    let mut groups = Vec::new();
    for field in fields(message) {
        let field = field?;
        match field.number {
            1 => {
                for string in fields(field.bytes()?) {
                    let string = string?;
                    if string.number == 1 {
                        block.strings.push(string.bytes()?);
                    }
                }
            }
            2 => groups.push(field.bytes()?),
            17 => block.granularity = field.int()?,
            19 => block.latitude_offset = field.int()?,
            20 => block.longitude_offset = field.int()?,
            _ => {}
        }
    }
    groups
        .iter()
        .try_for_each(|group| block.add_group(extract, group))
}

impl Block<'_> {
    fn add_group(&self, extract: &mut Extract, group: &[u8]) -> Result<(), MapFault> {
        for element in fields(group) {
            let element = element?;
            match element.number {
                1 => self.add_node(extract, element.bytes()?)?,
                2 => self.add_dense_nodes(extract, element.bytes()?)?,
                3 => self.add_way(extract, element.bytes()?)?,
                4 => self.add_relation(extract, element.bytes()?)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn add_node(&self, extract: &mut Extract, message: &[u8]) -> Result<(), MapFault> {
        let (mut id, mut latitude, mut longitude) = (None, None, None);
        let mut tags = TagIndices::default();
        for field in fields(message) {
            let field = field?;
            match field.number {
                1 => id = Some(field.sint()?),
                8 => latitude = Some(field.sint()?),
                9 => longitude = Some(field.sint()?),
                _ => tags.extend(&field)?,
            }
        }
        let longitude = required(longitude, "the longitude of a node")?;
        let latitude = required(latitude, "the latitude of a node")?;
        let place = self.place(longitude, latitude)?;
        extract.add_node(required(id, "the id of a node")?, place, tags.read(self)?)
    }

    /// Adds nodes stored as columns: ids, latitudes, longitudes, and the tags of all nodes, with a 0 after those of
    /// each.
    fn add_dense_nodes(&self, extract: &mut Extract, message: &[u8]) -> Result<(), MapFault> {
        let (mut ids, mut tags) = (ProtobufNumbers::default(), ProtobufNumbers::default());
        let (mut latitudes, mut longitudes) =
            (ProtobufNumbers::default(), ProtobufNumbers::default());
        for field in fields(message) {
            let field = field?;
            match field.number {
                1 => ids.extend(&field)?,
                8 => latitudes.extend(&field)?,
                9 => longitudes.extend(&field)?,
                10 => tags.extend(&field)?,
                _ => {}
            }
        }
        let mut indices = tags.ints();
        let places = longitudes.sums().zip(latitudes.sums());
        for (id, (longitude, latitude)) in ids.sums().zip(places) {
            let place = self.place(longitude?, latitude?)?;
            let mut tags = Tags::new();
            while let Some(key) = indices.next().transpose()?.filter(|key| *key != 0) {
                let value = indices.next().transpose()?;
                self.add_tag(&mut tags, key, required(value, "the value of a tag")?)?;
            }
            extract.add_node(id?, place, tags)?;
        }
        Ok(())
    }

    fn add_way(&self, extract: &mut Extract, message: &[u8]) -> Result<(), MapFault> {
        let (mut id, mut nodes) = (None, ProtobufNumbers::default());
        let mut tags = TagIndices::default();
        for field in fields(message) {
            let field = field?;
            match field.number {
                1 => id = Some(field.int()?),
                8 => nodes.extend(&field)?,
                _ => tags.extend(&field)?,
            }
        }
        extract.add_way(OsmWay {
            id: required(id, "the id of a way")?,
            nodes: nodes.sums().collect::<Result<_, _>>()?,
            tags: tags.read(self)?,
        })
    }

    fn add_relation(&self, extract: &mut Extract, message: &[u8]) -> Result<(), MapFault> {
        let (mut members, mut kinds) = (ProtobufNumbers::default(), ProtobufNumbers::default());
        let mut tags = TagIndices::default();
        for field in fields(message) {
            let field = field?;
            match field.number {
                9 => members.extend(&field)?,
                10 => kinds.extend(&field)?,
                _ => tags.extend(&field)?,
            }
        }
        let mut ways = Vec::new();
        for (member, kind) in members.sums().zip(kinds.ints()) {
            match (member?, kind?) {
                (way, 1) => ways.push(way),
                (_node_or_relation, 0 | 2) => {}
                (_, other) => {
                    let what = format_args!("a member of a relation has the unknown kind {other}");
                    return Err(syntax(what));
                }
            }
        }
        let tags = tags.read(self)?;
        extract.add_relation(OsmRelation { ways, tags })
    }

    /// Converts coordinates from the block's unit to degrees: longitude, latitude.
    fn place(&self, longitude: i64, latitude: i64) -> Result<(f64, f64), MapFault> {
        let degrees = |offset: i64, number: i64| {
            let nanodegrees = number.checked_mul(self.granularity);
            let nanodegrees = nanodegrees.and_then(|it| it.checked_add(offset));
            Ok(1e-9 * nanodegrees.ok_or(ProtobufError::TooLarge)? as f64)
        };
        let longitude: Result<f64, ProtobufError> = degrees(self.longitude_offset, longitude);
        Ok((longitude?, degrees(self.latitude_offset, latitude)?))
    }

    /// Adds a tag, given by the indices of its strings, if it is relevant.
    fn add_tag(&self, tags: &mut Tags, key: u64, value: u64) -> Result<(), MapFault> {
        let string = |index: u64| {
            let found = usize::try_from(index)
                .ok()
                .and_then(|it| self.strings.get(it));
            required(found.copied(), "a string of a tag")
        };
        let (key, value) = (string(key)?, string(value)?);
        // keys of rules are UTF-8, so any other key matches none
        let Some(key) = str::from_utf8(key)
            .ok()
            .filter(|key| matters(self.rules, key))
        else {
            return Ok(());
        };
        let value = str::from_utf8(value)
            .map_err(|_| syntax(format_args!("the value of a tag `{key}` is not UTF-8 text")))?;
        tags.insert(key.to_owned(), value.to_owned());
        Ok(())
    }
}

/// The tags of an element: indices of keys and values, in two columns.
#[derive(Default)]
struct TagIndices<'a> {
    keys: ProtobufNumbers<'a>,
    values: ProtobufNumbers<'a>,
}

impl<'a> TagIndices<'a> {
    /// Appends a field of a node, way or relation if it contains tags.
    fn extend(&mut self, field: &ProtobufField<'a>) -> Result<(), ProtobufError> {
        match field.number {
            2 => self.keys.extend(field),
            3 => self.values.extend(field),
            _ => Ok(()),
        }
    }

    fn read(&self, block: &Block<'_>) -> Result<Tags, MapFault> {
        let mut tags = Tags::new();
        for (key, value) in self.keys.ints().zip(self.values.ints()) {
            block.add_tag(&mut tags, key?, value?)?;
        }
        Ok(tags)
    }
}
