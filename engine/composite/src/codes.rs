//! Diagnostics of composites, one file per code, grouped by: file syntax, values, names, implementations, wires,
//! connections, topics, promotions, queues and gateways, processes, nesting, bindings, types, proxies and bridges. The
//! diagnostics of flattening are in `asmotion-plan`.

pub(crate) mod c001;
pub(crate) mod c002;
pub(crate) mod c003;
pub(crate) mod c004;
pub(crate) mod c005;
pub(crate) mod c006;
pub(crate) mod c007;
pub(crate) mod c008;
pub(crate) mod c009;
pub(crate) mod c010;
pub(crate) mod c011;
pub(crate) mod c012;
pub(crate) mod c013;
pub(crate) mod c014;
pub(crate) mod c015;
pub(crate) mod c016;
pub(crate) mod c017;
pub(crate) mod c018;
pub(crate) mod c020;
pub(crate) mod c021;
pub(crate) mod c022;
pub(crate) mod c023;
pub(crate) mod c024;
pub(crate) mod c025;
pub(crate) mod c026;
pub(crate) mod c027;
pub(crate) mod c028;
pub(crate) mod c029;
pub(crate) mod c030;
pub(crate) mod c031;
pub(crate) mod c032;
pub(crate) mod c033;
pub(crate) mod c034;
pub(crate) mod c035;
pub(crate) mod c040;
pub(crate) mod c041;
pub(crate) mod c042;
pub(crate) mod c043;
pub(crate) mod c044;
pub(crate) mod c045;
pub(crate) mod c046;
pub(crate) mod c047;
pub(crate) mod c048;
pub(crate) mod c049;
pub(crate) mod c050;
pub(crate) mod c051;
pub(crate) mod c052;
pub(crate) mod c053;
pub(crate) mod c055;
pub(crate) mod c056;
pub(crate) mod c057;
pub(crate) mod c058;
pub(crate) mod c060;
pub(crate) mod c061;
pub(crate) mod c062;
pub(crate) mod c063;
pub(crate) mod c064;
pub(crate) mod c066;
pub(crate) mod c070;
pub(crate) mod c071;
pub(crate) mod c072;
pub(crate) mod c073;
pub(crate) mod c074;
pub(crate) mod c075;
pub(crate) mod c076;
pub(crate) mod c080;
pub(crate) mod c081;
pub(crate) mod c090;
pub(crate) mod c091;
pub(crate) mod c092;
pub(crate) mod c093;
pub(crate) mod c094;
pub(crate) mod c095;
pub(crate) mod c096;
pub(crate) mod c097;
pub(crate) mod c098;
pub(crate) mod c099;
pub(crate) mod c100;
pub(crate) mod c101;
pub(crate) mod c102;
pub(crate) mod c103;
pub(crate) mod c104;
pub(crate) mod c110;
pub(crate) mod c111;
pub(crate) mod c112;
pub(crate) mod c113;
pub(crate) mod c114;
pub(crate) mod c115;
pub(crate) mod c116;
pub(crate) mod c120;
pub(crate) mod c121;
pub(crate) mod c122;
pub(crate) mod c123;
pub(crate) mod c124;
pub(crate) mod c125;
pub(crate) mod c126;
pub(crate) mod c127;
pub(crate) mod c128;
pub(crate) mod c129;
pub(crate) mod c140;
pub(crate) mod c141;
pub(crate) mod c142;
pub(crate) mod c143;
pub(crate) mod c144;
pub(crate) mod c145;
pub(crate) mod c146;
pub(crate) mod c147;
pub(crate) mod c148;
pub(crate) mod c149;
pub(crate) mod c150;
pub(crate) mod c151;
pub(crate) mod c153;
pub(crate) mod c154;
pub(crate) mod c158;
pub(crate) mod c159;
pub(crate) mod c160;
pub(crate) mod c161;
pub(crate) mod c170;
pub(crate) mod c171;
pub(crate) mod c172;
pub(crate) mod c173;
pub(crate) mod c174;
pub(crate) mod c175;
pub(crate) mod c180;
pub(crate) mod c181;
pub(crate) mod c182;
pub(crate) mod c183;
pub(crate) mod c184;
pub(crate) mod c185;
pub(crate) mod c186;
pub(crate) mod c187;
pub(crate) mod c188;
pub(crate) mod c189;
pub(crate) mod c190;
pub(crate) mod c200;
pub(crate) mod c201;
pub(crate) mod c210;

use asmotion_diagnostics::Code;

/// All codes of this crate in ascending order.
pub const CODES: &[&Code] = &[
    c001::InvalidToml::CODE,
    c002::UnreadableComposite::CODE,
    c003::UnknownKey::CODE,
    c004::MissingKey::CODE,
    c005::WrongKeyType::CODE,
    c006::UnknownOption::CODE,
    c007::KeyOutOfRange::CODE,
    c008::UnknownSchema::CODE,
    c009::InvalidName::CODE,
    c010::ExclusiveKeys::CODE,
    c011::SubstitutionNotAllowed::CODE,
    c012::InvalidSubstitution::CODE,
    c013::UnknownSetting::CODE,
    c014::UnsetVariable::CODE,
    c015::InvalidSetting::CODE,
    c016::SettingOutOfRange::CODE,
    c017::MissingSetting::CODE,
    c018::DuplicatePort::CODE,
    c020::UnknownName::CODE,
    c021::UnknownMember::CODE,
    c022::MissingBroker::CODE,
    c023::DuplicateId::CODE,
    c024::UnknownImplementation::CODE,
    c025::ImplementationNotInBuild::CODE,
    c026::UndeclaredMember::CODE,
    c027::DeclarationDiffers::CODE,
    c028::UnknownProperty::CODE,
    c029::SubscriptionNeverRead::CODE,
    c030::WireMismatch::CODE,
    c031::DanglingReference::CODE,
    c032::ReferenceWiredTwice::CODE,
    c033::NoTimeout::CODE,
    c034::AwaitsSeveral::CODE,
    c035::MasterCycle::CODE,
    c040::WrongDirection::CODE,
    c041::NoComponentJoined::CODE,
    c042::ConnectionMismatch::CODE,
    c043::TwoWriters::CODE,
    c044::QueueWithoutSize::CODE,
    c045::UnconnectedInput::CODE,
    c046::OpenInput::CODE,
    c047::UnsyncAcrossThreads::CODE,
    c048::IdleKey::CODE,
    c049::DuplicateConnection::CODE,
    c050::TopicWithTwoTypes::CODE,
    c051::SilentTopic::CODE,
    c052::UnknownRename::CODE,
    c053::OutputOnTwoTopics::CODE,
    c055::EngineTopic::CODE,
    c056::UnknownTopicSettings::CODE,
    c057::Uncarried::CODE,
    c058::TooManyThreads::CODE,
    c060::DuplicatePromotion::CODE,
    c061::NoMqueueLayout::CODE,
    c062::NoMqueueSize::CODE,
    c063::NoGateway::CODE,
    c064::InvalidAddress::CODE,
    c066::GatewayInTwoProcesses::CODE,
    c070::PlacedTwice::CODE,
    c071::PlacedNowhere::CODE,
    c072::DuplicateProcess::CODE,
    c073::UnknownRecordedTopic::CODE,
    c074::LocalWireAcross::CODE,
    c075::NoCommonBroker::CODE,
    c076::UnsupportedKey::CODE,
    c080::CircularInclusion::CODE,
    c081::CompositesTooDeep::CODE,
    c090::UnknownBoundFunction::CODE,
    c091::WrongFunctionKind::CODE,
    c092::WrongLocationArity::CODE,
    c093::UnknownLiteral::CODE,
    c094::WrongLiteralType::CODE,
    c095::WrongFieldType::CODE,
    c096::AmbiguousField::CODE,
    c097::UnboundMonitored::CODE,
    c098::UnboundOut::CODE,
    c099::UnknownKept::CODE,
    c100::WrongArgument::CODE,
    c101::OtherMainRule::CODE,
    c102::UnlistedAnnotation::CODE,
    c103::OtherInterface::CODE,
    c104::Unannotated::CODE,
    c110::UnknownType::CODE,
    c111::RecursiveType::CODE,
    c112::ConflictingTypes::CODE,
    c113::TypeDiffersFromBuild::CODE,
    c114::TypeNotInBuild::CODE,
    c115::UnknownField::CODE,
    c116::TypesTooLarge::CODE,
    c120::WrongPortDirection::CODE,
    c121::PortOfOtherComponent::CODE,
    c122::PortNotListed::CODE,
    c123::PortTypeDiffers::CODE,
    c124::ShapeMismatch::CODE,
    c125::InvalidCondition::CODE,
    c126::NoIdleNotification::CODE,
    c127::StaleWithoutPeriod::CODE,
    c128::NothingToVerify::CODE,
    c129::NothingToLeaveOut::CODE,
    c140::UnknownElement::CODE,
    c141::UnlistedDomain::CODE,
    c142::UnknownKeyVariable::CODE,
    c143::WrongSelectorType::CODE,
    c144::LocationBoundTwice::CODE,
    c145::InvalidTerm::CODE,
    c146::UndefinedAtStart::CODE,
    c147::StateWithoutExit::CODE,
    c148::UnreadBoundFunction::CODE,
    c149::LiteralWithoutSource::CODE,
    c150::UnmappedOperation::CODE,
    c151::NoSingleProvider::CODE,
    c153::ProgramWithoutDeclaration::CODE,
    c154::ProgramElsewhere::CODE,
    c158::RobotWithoutDeclaration::CODE,
    c159::RobotNotAsked::CODE,
    c160::UnknownProtocolEnd::CODE,
    c161::UnfitProtocolFunction::CODE,
    c170::UnknownRosType::CODE,
    c171::UnusedBridge::CODE,
    c172::MappedTwice::CODE,
    c173::InvalidRosName::CODE,
    c174::NoTransformation::CODE,
    c175::WrongRosDefinition::CODE,
    c180::UnknownRosOperation::CODE,
    c181::RosOperationDiffers::CODE,
    c182::OperationNotMapped::CODE,
    c183::OperationMappedTwice::CODE,
    c184::WrongConverter::CODE,
    c185::NoSingleRosService::CODE,
    c186::HiddenComponent::CODE,
    c187::EndlessCircle::CODE,
    c188::UnconvertedLiteral::CODE,
    c189::TimeoutWithinPeriod::CODE,
    c190::NoCertificate::CODE,
    c200::InvalidWatch::CODE,
    c201::UnwatchedProperties::CODE,
    c210::InvalidInstances::CODE,
];
