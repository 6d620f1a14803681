// a location met late begins as it would have begun: with the domains, the time and without the agent
// of the initial state
asm initial_values_of_the_initial_state
import StandardLibrary
signature:
  abstract domain Robot
  static first: Robot
  controlled robots: Integer -> Integer
  controlled began: Integer -> Integer
  controlled who: Integer -> Agent
  controlled x: Integer
  controlled y: Integer
  controlled z: Agent
  static a: Agent
definitions:
  rule r_agent = z := who(1)
  main rule r_Main = par
    extend Robot with $r do skip
    if x = 1 then par
      x := robots(7)
      y := began(7)
      program(a)
    endpar else x := 1 endif
  endpar
default init s0:
  function x = 0
  function robots($n in Integer) = size(Robot)
  function began($n in Integer) = currTimeSecs
  function who($n in Integer) = self
  agent Agent: r_agent[]
//? step 1: time 3000000000
//? step 2: time 9000000000
//= step 1: Robot + {robot!1}, x := 1
//= step 2: Robot + {robot!2}, x := 1, y := 3, z := undef
