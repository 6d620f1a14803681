// a domain may be defined by one that is defined below it
asm domains_in_any_order
import StandardLibrary
signature:
  domain Large subsetof Integer
  domain Even subsetof Integer
  controlled x: Powerset(Integer)
  controlled limit: Integer
definitions:
  domain Large = {$n in Even | $n > 2: $n}
  domain Even = {$n in {0 : 3}: $n * limit}
  main rule r_Main = x := Large
default init s0:
  function limit = 2
//= step 1: x := {4,6}
