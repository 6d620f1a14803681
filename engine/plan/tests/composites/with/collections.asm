asm collections
import StandardLibrary
signature:
  monitored ranges: Seq(Real)
  monitored names: Powerset(String)
  monitored counts: Bag(Integer)
  monitored place: Prod(Real, Real, Real)
  monitored nested: Seq(Seq(Integer))
  controlled n: Integer
definitions:
  main rule r_Main =
    n := length(ranges) + length(nested) + size(names) + size(asSet(counts)) + rtoi(first(place))
