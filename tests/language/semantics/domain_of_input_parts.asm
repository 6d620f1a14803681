// the parts of an input are in the domains of the codomain, or undef; 4 is not in Few
asm domain_of_input_parts
import StandardLibrary
signature:
  domain Few subsetof Integer
  monitored row: Seq(Few)
  monitored set: Powerset(Few)
  monitored pair: Prod(Few, String)
  monitored deep: Seq(Prod(Boolean, Powerset(Few)))
  controlled rowKept: Seq(Integer)
  controlled setKept: Powerset(Integer)
  controlled pairKept: Prod(Integer, String)
  controlled deepKept: Seq(Prod(Boolean, Powerset(Integer)))
definitions:
  domain Few = {3, 5, 7}
  main rule r_Main = par
    if isDef(row) then rowKept := row endif
    if isDef(set) then setKept := set endif
    if isDef(pair) then pairKept := pair endif
    if isDef(deep) then deepKept := deep endif
  endpar
//? step 1: row = [3,7], set = {5}, pair = (3,"a"), deep = [(true,{3})]
//= step 1: rowKept := [3,7], setKept := {5}, pairKept := (3,"a"), deepKept := [(true,{3})]
//? step 2: row = [3], set = {5}, pair = (3,"a"), deep = [(true,{3,4})]
//= step 2: R022
