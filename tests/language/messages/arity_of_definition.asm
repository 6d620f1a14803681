asm arity_of_definition
import StandardLibrary
signature:
  static twice: Integer -> Integer
definitions:
  function twice($a in Integer, $b in Integer) = $a  //~ A008
  main rule r_Main = skip
