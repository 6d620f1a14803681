// an initial value may depend on others of the same function, above and below it
asm initial_values_recursive
import StandardLibrary
signature:
  domain Small subsetof Integer
  controlled up: Small -> Integer
  controlled down: Small -> Integer
  controlled x: Integer
definitions:
  domain Small = {0 : 4}
  main rule r_Main = x := up(4) + down(0)
default init s0:
  function up($n in Small) = if $n = 0 then 1 else up($n - 1) * 2 endif
  function down($n in Small) = if $n = 4 then 100 else down($n + 1) + 100 endif
//= step 1: x := 516
