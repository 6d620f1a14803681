// a location may hold a rule, with parameters or without
asm rule_value
import StandardLibrary
signature:
  controlled act: Rule
  controlled set: Rule(Integer)
  controlled x: Integer
definitions:
  rule r_one = x := 1
  rule r_two = x := 2
  rule r_set($n in Integer) = x := $n
  main rule r_Main = par
    if x = 2 then set[7] else act endif
    act := <<r_two>>
  endpar
default init s0:
  function act = <<r_one>>
  function set = <<r_set(Integer)>>
//= step 1: act := rule r_two(), x := 1
//= step 2: act := rule r_two(), x := 2
//= step 3: act := rule r_two(), x := 7
