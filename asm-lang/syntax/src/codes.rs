//! The diagnostic codes for the text of specifications and scenarios, one file for each. New codes
//! take the next number of their group.

pub(crate) mod l001;
pub(crate) mod l002;
pub(crate) mod l003;
pub(crate) mod l004;
pub(crate) mod l005;
pub(crate) mod l006;
pub(crate) mod l007;
pub(crate) mod l008;
pub(crate) mod l009;
pub(crate) mod l010;
pub(crate) mod l011;
pub(crate) mod l020;
pub(crate) mod l021;
pub(crate) mod l022;
pub(crate) mod l023;
pub(crate) mod l024;
pub(crate) mod l025;
pub(crate) mod l030;
pub(crate) mod l031;
pub(crate) mod l032;
pub(crate) mod l033;
pub(crate) mod l034;
pub(crate) mod l035;
pub(crate) mod l036;
pub(crate) mod l037;
pub(crate) mod l038;
pub(crate) mod l039;
pub(crate) mod l040;
pub(crate) mod l041;
pub(crate) mod l050;
pub(crate) mod l051;
pub(crate) mod l052;
pub(crate) mod l053;
pub(crate) mod l054;
pub(crate) mod l055;
pub(crate) mod l056;
pub(crate) mod l057;
pub(crate) mod l058;
pub(crate) mod l059;
pub(crate) mod l060;
pub(crate) mod l061;
pub(crate) mod l062;
pub(crate) mod l063;
pub(crate) mod l064;
pub(crate) mod l065;
pub(crate) mod l066;
pub(crate) mod l070;
pub(crate) mod l071;
pub(crate) mod l072;
pub(crate) mod l073;
pub(crate) mod l074;
pub(crate) mod l075;
pub(crate) mod l076;
pub(crate) mod l077;
pub(crate) mod l078;
pub(crate) mod l079;
pub(crate) mod l080;
pub(crate) mod v001;
pub(crate) mod v002;
pub(crate) mod v003;
pub(crate) mod v004;
pub(crate) mod v005;
pub(crate) mod v006;
pub(crate) mod v007;
pub(crate) mod v008;
pub(crate) mod v009;
pub(crate) mod v010;

use asmotion_diagnostics::Code;

/// All codes of this crate, sorted by name.
pub const CODES: &[&Code] = &[
    l001::UnknownCharacters::CODE,
    l002::ForeignLetters::CODE,
    l003::OpenComment::CODE,
    l004::OpenQuote::CODE,
    l005::CharLength::CODE,
    l006::IntegerTooLarge::CODE,
    l007::ExponentInNumber::CODE,
    l008::BarePoint::CODE,
    l009::ForeignSign::CODE,
    l010::StraySemicolon::CODE,
    l011::ElementName::CODE,
    l020::EmptyFile::CODE,
    l021::NoHeading::CODE,
    l022::SecondHeading::CODE,
    l023::SecondExport::CODE,
    l024::SecondMain::CODE,
    l025::AgentOutsideInit::CODE,
    l030::FileCutOff::CODE,
    l031::UnclosedBlock::CODE,
    l032::UnclosedElseIf::CODE,
    l033::ClosesNothing::CODE,
    l034::SeveralRules::CODE,
    l035::MissingRule::CODE,
    l036::BracketedRule::CODE,
    l037::CallWithoutBrackets::CODE,
    l038::BareQuantifier::CODE,
    l039::NestedTooDeep::CODE,
    l040::CommaBetweenRules::CODE,
    l041::SquareArguments::CODE,
    l050::EqualsForUpdate::CODE,
    l051::UpdateForEquals::CODE,
    l052::MissingWord::CODE,
    l053::UnknownWord::CODE,
    l054::ReservedName::CODE,
    l055::ComplexName::CODE,
    l056::Misnamed::CODE,
    l057::UnusedWord::CODE,
    l058::UnexpectedToken::CODE,
    l059::ProductSign::CODE,
    l060::InfixMembership::CODE,
    l061::ReturnOfNoRule::CODE,
    l062::TooManyErrors::CODE,
    l063::NotAnAssignment::CODE,
    l064::UnneededEnd::CODE,
    l065::UnbracketedLet::CODE,
    l066::MissingElement::CODE,
    l070::OldExists::CODE,
    l071::OldInterval::CODE,
    l072::FewRules::CODE,
    l073::OutOfOrder::CODE,
    l074::NoSection::CODE,
    l075::PropertyPrefix::CODE,
    l076::CalledEarly::CODE,
    l077::CompoundAssignment::CODE,
    l078::InfixDivision::CODE,
    l079::BareInterval::CODE,
    l080::QualifiedElement::CODE,
    v001::NoScenarioHeading::CODE,
    v002::NoLoadCommand::CODE,
    v003::UnknownCommand::CODE,
    v004::IncompleteCommand::CODE,
    v005::UnendedCommand::CODE,
    v006::OpenBlock::CODE,
    v007::StrayBlockEnd::CODE,
    v008::DuplicateBlock::CODE,
    v009::LateHeading::CODE,
    v010::BlocksNestTooDeep::CODE,
];
