asm circular_domain_definition
import StandardLibrary
signature:
  domain Small subsetof Integer
  domain Smaller subsetof Integer
definitions:
  domain Small = {$x in Smaller | $x > 1: $x}  //~ A035
  domain Smaller = {$x in Small | $x < 9: $x}
  main rule r_Main = skip
