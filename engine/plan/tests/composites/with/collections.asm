asm collections
import StandardLibrary
signature:
  monitored ranges: Seq(Real)
  monitored names: Powerset(String)
  monitored counts: Bag(Integer)
  monitored place: Prod(Real, Real, Real)
  monitored nested: Seq(Seq(Integer))
definitions:
  main rule r_Main = skip
