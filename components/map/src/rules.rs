//! Rules that map tags to occupancy, for OSM and for GeoJSON whose properties are tags (indoor plans: OpenStreetMap's
//! Simple Indoor Tagging).

use std::collections::BTreeMap;

use asmotion_geometry::Occupancy;

/// The tags of a feature.
pub type Tags = BTreeMap<String, String>;

/// The built-in rules, one per line; the first match wins. A rule is `key=value|value` or `key=*` (any value except
/// `no`), followed by the occupancy of the feature (`occupied`, `free`, `unknown`, `ignore`), and by options: `layer=`
/// (higher layers are drawn over lower ones), `width=` of lines and `spot=` (diameter) of points in metres, unless the
/// feature has tags for them, and `area` if a closed line stands for the area within.
pub const DEFAULT_RULES: &str = "
# said outright
occupancy=occupied  occupied layer=3 area width=0.1 spot=0.1
occupancy=free      free     layer=2 area width=1
occupancy=unknown   unknown  layer=2 area width=1

# not on this floor
location=underground|underwater|roof|overhead  ignore
tunnel=building_passage  free layer=5 width=3
tunnel=*            ignore

# indoors
indoor=room|area|corridor|hall  free layer=1 area
indoor=wall|pillar|column       occupied layer=3 width=0.15 spot=0.4
indoor=door|opening             free layer=5 width=0.3 spot=1
furniture=*         occupied layer=3 area width=0.1 spot=0.5

# water
natural=water|bay   occupied layer=1 area
landuse=reservoir|basin|salt_pond  occupied layer=1 area
leisure=swimming_pool|swimming_area  occupied layer=1 area
amenity=fountain    occupied layer=3 area spot=2
waterway=riverbank|dock|boatyard   occupied layer=1 area
waterway=river|canal|fairway       occupied layer=1 width=8
waterway=stream|ditch|drain|weir|dam  occupied layer=1 width=1.5
natural=cliff|coastline  occupied layer=1 width=1

# ways
highway=street_lamp|milestone|traffic_sign  occupied layer=4 spot=0.3
highway=steps|elevator|proposed|construction  occupied layer=2 width=2
highway=motorway|motorway_link|trunk|trunk_link  free layer=2 width=9
highway=primary|primary_link|secondary|secondary_link  free layer=2 width=7
highway=tertiary|tertiary_link|unclassified|residential|living_street|road  free layer=2 width=6
highway=service|track|pedestrian  free layer=2 width=4
highway=*           free layer=2 width=2
man_made=pier|bridge|breakwater  free layer=2 area width=2
railway=platform    free layer=2 area width=2

# buildings
building=roof|carport  ignore
building=*          occupied layer=3 area spot=2
man_made=storage_tank|silo|tower|chimney|mast|water_tower|obelisk|gasometer  occupied layer=3 area spot=2
historic=monument|memorial|statue|column  occupied layer=3 area spot=1

# barriers, and the ways through them
barrier=gate|entrance|lift_gate|swing_gate|sliding_gate|sally_port|toll_booth|border_control|height_restrictor  free layer=5 width=1.5 spot=3
barrier=kerb|kissing_gate  ignore
barrier=hedge       occupied layer=4 width=0.8 spot=0.8
barrier=*           occupied layer=4 width=0.3 spot=0.5
natural=tree        occupied layer=4 spot=0.6
power=tower|pole    occupied layer=4 spot=0.5
advertising=column  occupied layer=4 spot=1.4
";

/// One rule: selects features by a tag, and defines how they are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureRule {
    key: String,
    /// Matching values; empty for any value except `no`.
    values: Vec<String>,
    /// Occupancy of the feature; `None` if it is not drawn.
    pub occupancy: Option<Occupancy>,
    /// Layer of the feature; higher layers are drawn over lower ones.
    pub layer: u8,
    /// Width of lines without a width tag, m.
    pub width: f64,
    /// Diameter of points, m; `None` if points are not drawn.
    pub spot: Option<f64>,
    /// `true` if a closed line stands for the area within.
    pub area: bool,
}

/// A list of rules, of which the first match wins.
#[derive(Clone, Debug, PartialEq)]
pub struct Rules(Vec<FeatureRule>);

/// A rule with invalid syntax.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("rule `{rule}`: {why}")]
pub struct RuleError {
    /// The rule as written.
    pub rule: String,
    /// The violated requirement.
    pub why: String,
}

impl Default for Rules {
    fn default() -> Self {
        // never fails: a test parses the text
        Self::parse(DEFAULT_RULES).unwrap_or(Self(Vec::new()))
    }
}

impl Rules {
    /// Parses rules, one per line or separated by `;`. Empty lines and `#` comments are skipped.
    ///
    /// # Errors
    /// The first rule that violates the syntax, with the reason.
    pub fn parse(text: &str) -> Result<Self, RuleError> {
        let lines = text
            .lines()
            .map(|line| line.split('#').next().unwrap_or(""));
        let rules = lines.flat_map(|line| line.split(';')).map(str::trim);
        let rules = rules
            .filter(|rule| !rule.is_empty())
            .map(FeatureRule::parse);
        rules.collect::<Result<_, _>>().map(Self)
    }

    /// These rules, followed by `others`.
    pub fn followed_by(mut self, others: Self) -> Self {
        self.0.extend(others.0);
        self
    }

    /// The first rule that matches the tags.
    pub fn of(&self, tags: &Tags) -> Option<&FeatureRule> {
        self.0.iter().find(|rule| rule.matches(tags))
    }

    /// Returns whether any rule uses this key.
    pub fn uses_key(&self, key: &str) -> bool {
        self.0.iter().any(|rule| rule.key == key)
    }
}

impl FeatureRule {
    fn parse(text: &str) -> Result<Self, RuleError> {
        let wrong = |why: String| RuleError {
            rule: text.to_owned(),
            why,
        };
        let mut words = text.split_whitespace();
        let (key, values) = words
            .next()
            .and_then(|tag| tag.split_once('='))
            .ok_or_else(|| wrong("it must begin with `key=value`".to_owned()))?;
        let meaning = words.next().unwrap_or("");
        let mut rule = Self {
            key: key.to_owned(),
            values: match values {
                "*" => Vec::new(),
                values => values.split('|').map(str::to_owned).collect(),
            },
            occupancy: occupancy(meaning).ok_or_else(|| {
                wrong(format!(
                    "`{meaning}` is not one of occupied, free, unknown, ignore"
                ))
            })?,
            layer: 3,
            width: 0.0,
            spot: None,
            area: false,
        };
        for word in words {
            rule.option(word).map_err(&wrong)?;
        }
        Ok(rule)
    }

    fn option(&mut self, word: &str) -> Result<(), String> {
        let number = |text: &str| {
            let number: Option<f64> = text.parse().ok();
            let number = number.filter(|number| (0.0..=1000.0).contains(number));
            number.ok_or(format!("`{word}` needs a number from 0 to 1000"))
        };
        match word.split_once('=') {
            None if word == "area" => self.area = true,
            Some(("layer", layer)) => self.layer = number(layer)?.min(255.0) as u8,
            Some(("width", width)) => self.width = number(width)?,
            Some(("spot", spot)) => self.spot = Some(number(spot)?),
            _ => {
                return Err(format!(
                    "`{word}` is not one of area, layer=, width=, spot="
                ));
            }
        }
        Ok(())
    }

    fn matches(&self, tags: &Tags) -> bool {
        tags.get(&self.key)
            .is_some_and(|value| match &self.values[..] {
                [] => value != "no",
                values => values.contains(value),
            })
    }

    /// Width of a line with these tags, m: its tag `width_m` or `width`, otherwise the rule's width.
    pub fn width_of(&self, tags: &Tags) -> f64 {
        tagged_length(tags, ["width_m", "width"]).unwrap_or(self.width)
    }

    /// Diameter of a point with these tags, m: its tag `diameter_m` or `diameter`, otherwise the rule's; `None` if
    /// points are not drawn.
    pub fn spot_of(&self, tags: &Tags) -> Option<f64> {
        let spot = self.spot?;
        Some(tagged_length(tags, ["diameter_m", "diameter"]).unwrap_or(spot))
    }
}

/// The value of the first tag of two that is present, if it is a length between 0 and 200 m.
fn tagged_length(tags: &Tags, keys: [&str; 2]) -> Option<f64> {
    let text = keys.iter().find_map(|key| tags.get(*key))?;
    let metres = text.trim_end_matches(['m', ' ']).parse().ok();
    metres.filter(|metres| (0.0..=200.0).contains(metres))
}

fn occupancy(word: &str) -> Option<Option<Occupancy>> {
    match word {
        "occupied" => Some(Some(Occupancy::Occupied)),
        "free" => Some(Some(Occupancy::Free)),
        "unknown" => Some(Some(Occupancy::Unknown)),
        "ignore" => Some(None),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(pairs: &[(&str, &str)]) -> Tags {
        pairs
            .iter()
            .map(|(key, value)| (key.to_string(), value.to_string()))
            .collect()
    }

    fn meaning(pairs: &[(&str, &str)]) -> Option<Option<Occupancy>> {
        Rules::default().of(&tags(pairs)).map(|rule| rule.occupancy)
    }

    #[test]
    fn the_default_rules_are_rules() {
        assert!(Rules::parse(DEFAULT_RULES).unwrap().0.len() > 30);
    }

    #[test]
    fn it_knows_what_blocks() {
        assert_eq!(
            meaning(&[("building", "yes")]),
            Some(Some(Occupancy::Occupied))
        );
        assert_eq!(meaning(&[("building", "no")]), None);
        assert_eq!(
            meaning(&[("highway", "footway")]),
            Some(Some(Occupancy::Free))
        );
        assert_eq!(
            meaning(&[("highway", "primary"), ("tunnel", "yes")]),
            Some(None)
        );
        assert_eq!(meaning(&[("barrier", "gate")]), Some(Some(Occupancy::Free)));
        assert_eq!(meaning(&[("shop", "car")]), None);
    }

    #[test]
    fn a_rule_in_front_wins() {
        let ours = Rules::parse("highway=motorway occupied width=12; # comment").unwrap();
        let rules = ours.followed_by(Rules::default());
        let rule = rules.of(&tags(&[("highway", "motorway")])).unwrap();
        assert_eq!(
            (rule.occupancy, rule.width),
            (Some(Occupancy::Occupied), 12.0)
        );
    }

    #[test]
    fn a_line_may_tell_its_width() {
        let rules = Rules::default();
        let width = |width: &str| {
            let tags = tags(&[("highway", "service"), ("width", width)]);
            rules.of(&tags).unwrap().width_of(&tags)
        };
        assert_eq!(
            [width("3.5"), width("3 m"), width("wide"), width("-2")],
            [3.5, 3.0, 4.0, 4.0]
        );
    }

    #[test]
    fn it_says_what_is_wrong_with_a_rule() {
        for (text, why) in [
            ("highway", "it must begin"),
            ("a=b blocked", "`blocked` is not one of"),
            ("a=b free wide", "`wide` is not one of"),
            ("a=b free width=-1", "needs a number"),
        ] {
            assert!(Rules::parse(text).unwrap_err().why.contains(why), "{text}");
        }
    }
}
