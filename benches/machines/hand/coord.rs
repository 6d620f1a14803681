//! The machine `coord`, written by hand.

use std::hint::black_box;

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Phase {
    Boot,
    Ready,
    Order,
    Pay,
    Ship,
    Waits,
    Recover,
    Failed,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Event {
    Tick,
    Req,
    Ack,
    Nack,
    Tmo,
    Rst,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Service {
    Auth,
    Stock,
    Bank,
    Mail,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ServiceState {
    Up,
    Slow,
    Down,
}

const SERVICES: [Service; 4] = [Service::Auth, Service::Stock, Service::Bank, Service::Mail];

const PHASES: [Phase; 8] = [
    Phase::Boot,
    Phase::Ready,
    Phase::Order,
    Phase::Pay,
    Phase::Ship,
    Phase::Waits,
    Phase::Recover,
    Phase::Failed,
];

#[derive(Clone, Copy)]
struct State {
    st: Phase,
    ev: Event,
    seed: i64,
    retries: i64,
    timer: i64,
    ticks: i64,
    idle: i64,
    orders: i64,
    errors: i64,
    svc: [ServiceState; 4],
    calls: [i64; 4],
    down: [i64; 4],
    hist: [i64; 8],
}

pub fn run(steps: u64, show: bool) -> Vec<String> {
    let mut state = State {
        st: Phase::Boot,
        ev: Event::Tick,
        seed: 1,
        retries: 0,
        timer: 0,
        ticks: 0,
        idle: 0,
        orders: 0,
        errors: 0,
        svc: [ServiceState::Up; 4],
        calls: [0; 4],
        down: [0; 4],
        hist: [0; 8],
    };
    for _ in 0..steps {
        let old = state;
        step(&old, &mut state);
        black_box(&mut state);
    }
    if show { shown(&state) } else { Vec::new() }
}

fn shown(state: &State) -> Vec<String> {
    let mut lines = vec![
        format!("st={:?}_ST", state.st)
            .to_uppercase()
            .replace("ST=", "st="),
        format!("ev={:?}_EV", state.ev)
            .to_uppercase()
            .replace("EV=", "ev="),
        format!("seed={}", state.seed),
        format!("retries={}", state.retries),
        format!("timer={}", state.timer),
        format!("ticks={}", state.ticks),
        format!("idle={}", state.idle),
        format!("orders={}", state.orders),
        format!("errors={}", state.errors),
    ];
    for (index, service) in SERVICES.iter().enumerate() {
        let service = format!("{service:?}_SVC").to_uppercase();
        let up = format!("{:?}_SSTAT", state.svc[index]).to_uppercase();
        lines.push(format!("svc({service})={up}"));
        lines.push(format!("calls({service})={}", state.calls[index]));
        lines.push(format!("down({service})={}", state.down[index]));
    }
    for (index, phase) in PHASES.iter().enumerate() {
        let phase = format!("{phase:?}_ST").to_uppercase();
        lines.push(format!("hist({phase})={}", state.hist[index]));
    }
    lines
}

fn event(old: &State, new: &mut State) {
    let drawn = ((old.seed * 8121) + 28411) % 134456;
    new.seed = drawn;
    match drawn % 6 {
        0 => {
            new.ev = Event::Tick;
        }
        1 => {
            new.ev = Event::Req;
        }
        2 => {
            new.ev = Event::Ack;
        }
        3 => {
            new.ev = Event::Nack;
        }
        4 => {
            new.ev = Event::Tmo;
        }
        _ => {
            new.ev = Event::Rst;
        }
    }
}

fn service(old: &State, new: &mut State, service: Service) {
    match old.svc[service as usize] {
        ServiceState::Up => {
            if ((old.seed + old.calls[service as usize]) % 11) == 0 {
                new.svc[service as usize] = ServiceState::Slow;
            }
        }
        ServiceState::Slow => {
            if ((old.seed + old.calls[service as usize]) % 5) == 0 {
                new.svc[service as usize] = ServiceState::Down;
            } else {
                if (old.seed % 3) == 0 {
                    new.svc[service as usize] = ServiceState::Up;
                }
            }
        }
        _ => {
            if old.down[service as usize] > 3 {
                new.svc[service as usize] = ServiceState::Up;
                new.down[service as usize] = 0;
            } else {
                new.down[service as usize] = old.down[service as usize] + 1;
            }
        }
    }
}

fn timer(old: &State, new: &mut State) {
    if old.timer > 0 {
        new.ticks = old.ticks + 1;
    } else {
        new.idle = old.idle + 1;
    }
}

fn boot_tick(old: &State, new: &mut State) {
    if old.svc[Service::Stock as usize] == ServiceState::Up {
        new.st = Phase::Ready;
        new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
        new.timer = 2;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn boot_ack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Ready;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 2;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn boot_nack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Ready;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 7;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn boot_tmo(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Down {
        new.st = Phase::Recover;
        new.errors = old.errors + 1;
    } else {
        if (old.ticks % 4) == 1 {
            new.st = Phase::Ready;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.orders = old.orders + 1;
        }
    }
}

fn boot_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_boot(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            boot_tick(old, new);
        }
        Event::Ack => {
            boot_ack(old, new);
        }
        Event::Nack => {
            boot_nack(old, new);
        }
        Event::Tmo => {
            boot_tmo(old, new);
        }
        Event::Req | Event::Rst => {
            boot_other(old, new);
        }
    }
}

fn ready_tick(old: &State, new: &mut State) {
    match old.svc[Service::Mail as usize] {
        ServiceState::Up => {
            new.st = Phase::Order;
            new.orders = old.orders + 1;
        }
        ServiceState::Slow => {
            new.st = Phase::Waits;
            new.timer = 5;
        }
        _ => {
            new.st = Phase::Recover;
        }
    }
}

fn ready_req(old: &State, new: &mut State) {
    if ((old.orders % 3) == 0) || (old.retries > 1) {
        new.st = Phase::Order;
        new.retries = 0;
        new.hist[Phase::Ready as usize] = old.hist[Phase::Ready as usize] + 1;
    } else {
        if old.timer >= 3 {
            new.timer = old.timer - 3;
            new.retries = old.retries + 1;
        } else {
            new.st = Phase::Ship;
        }
    }
}

fn ready_ack(old: &State, new: &mut State) {
    if old.svc[Service::Bank as usize] == ServiceState::Up {
        new.st = Phase::Order;
        new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
        new.timer = 4;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn ready_nack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Down {
        new.st = Phase::Recover;
        new.errors = old.errors + 1;
    } else {
        if (old.ticks % 4) == 1 {
            new.st = Phase::Order;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.orders = old.orders + 1;
        }
    }
}

fn ready_tmo(old: &State, new: &mut State) {
    if ((old.orders % 5) == 0) || (old.retries > 1) {
        new.st = Phase::Order;
        new.retries = 0;
        new.hist[Phase::Ready as usize] = old.hist[Phase::Ready as usize] + 1;
    } else {
        if old.timer >= 3 {
            new.timer = old.timer - 3;
            new.retries = old.retries + 1;
        } else {
            new.st = Phase::Waits;
        }
    }
}

fn ready_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_ready(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            ready_tick(old, new);
        }
        Event::Req => {
            ready_req(old, new);
        }
        Event::Ack => {
            ready_ack(old, new);
        }
        Event::Nack => {
            ready_nack(old, new);
        }
        Event::Tmo => {
            ready_tmo(old, new);
        }
        _ => {
            ready_other(old, new);
        }
    }
}

fn order_tick(old: &State, new: &mut State) {
    if old.svc[Service::Stock as usize] == ServiceState::Up {
        new.st = Phase::Pay;
        new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
        new.timer = 5;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn order_req(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Bank as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
    } else {
        new.st = Phase::Failed;
        new.timer = 2;
        new.hist[Phase::Order as usize] = old.hist[Phase::Order as usize] + 1;
    }
}

fn order_ack(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Mail as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
    } else {
        new.st = Phase::Order;
        new.timer = 3;
        new.hist[Phase::Order as usize] = old.hist[Phase::Order as usize] + 1;
    }
}

fn order_tmo(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Auth as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
    } else {
        new.st = Phase::Waits;
        new.timer = 4;
        new.hist[Phase::Order as usize] = old.hist[Phase::Order as usize] + 1;
    }
}

fn order_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_order(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            order_tick(old, new);
        }
        Event::Req => {
            order_req(old, new);
        }
        Event::Ack => {
            order_ack(old, new);
        }
        Event::Tmo => {
            order_tmo(old, new);
        }
        Event::Nack | Event::Rst => {
            order_other(old, new);
        }
    }
}

fn pay_tick(old: &State, new: &mut State) {
    if old.svc[Service::Mail as usize] == ServiceState::Up {
        new.st = Phase::Ship;
        new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        new.timer = 5;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn pay_req(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Auth as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
    } else {
        new.st = Phase::Boot;
        new.timer = 5;
        new.hist[Phase::Pay as usize] = old.hist[Phase::Pay as usize] + 1;
    }
}

fn pay_ack(old: &State, new: &mut State) {
    if old.svc[Service::Mail as usize] == ServiceState::Up {
        new.st = Phase::Ship;
        new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        new.timer = 8;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn pay_nack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Ship;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 4;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn pay_tmo(old: &State, new: &mut State) {
    if ((old.orders % 5) == 0) || (old.retries > 1) {
        new.st = Phase::Ship;
        new.retries = 0;
        new.hist[Phase::Pay as usize] = old.hist[Phase::Pay as usize] + 1;
    } else {
        if old.timer >= 3 {
            new.timer = old.timer - 3;
            new.retries = old.retries + 1;
        } else {
            new.st = Phase::Pay;
        }
    }
}

fn pay_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_pay(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            pay_tick(old, new);
        }
        Event::Req => {
            pay_req(old, new);
        }
        Event::Ack => {
            pay_ack(old, new);
        }
        Event::Nack => {
            pay_nack(old, new);
        }
        Event::Tmo => {
            pay_tmo(old, new);
        }
        _ => {
            pay_other(old, new);
        }
    }
}

fn ship_tick(old: &State, new: &mut State) {
    if ((old.orders % 4) == 0) || (old.retries > 1) {
        new.st = Phase::Waits;
        new.retries = 0;
        new.hist[Phase::Ship as usize] = old.hist[Phase::Ship as usize] + 1;
    } else {
        if old.timer >= 3 {
            new.timer = old.timer - 3;
            new.retries = old.retries + 1;
        } else {
            new.st = Phase::Failed;
        }
    }
}

fn ship_ack(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Bank as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
    } else {
        new.st = Phase::Recover;
        new.timer = 5;
        new.hist[Phase::Ship as usize] = old.hist[Phase::Ship as usize] + 1;
    }
}

fn ship_tmo(old: &State, new: &mut State) {
    match old.svc[Service::Stock as usize] {
        ServiceState::Up => {
            new.st = Phase::Waits;
            new.orders = old.orders + 1;
        }
        ServiceState::Slow => {
            new.st = Phase::Waits;
            new.timer = 5;
        }
        _ => {
            new.st = Phase::Recover;
        }
    }
}

fn ship_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_ship(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            ship_tick(old, new);
        }
        Event::Ack => {
            ship_ack(old, new);
        }
        Event::Tmo => {
            ship_tmo(old, new);
        }
        Event::Req | Event::Nack | Event::Rst => {
            ship_other(old, new);
        }
    }
}

fn waits_tick(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Stock as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
    } else {
        new.st = Phase::Ship;
        new.timer = 2;
        new.hist[Phase::Waits as usize] = old.hist[Phase::Waits as usize] + 1;
    }
}

fn waits_req(old: &State, new: &mut State) {
    match old.svc[Service::Bank as usize] {
        ServiceState::Up => {
            new.st = Phase::Recover;
            new.orders = old.orders + 1;
        }
        ServiceState::Slow => {
            new.st = Phase::Waits;
            new.timer = 5;
        }
        _ => {
            new.st = Phase::Recover;
        }
    }
}

fn waits_ack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Down {
        new.st = Phase::Recover;
        new.errors = old.errors + 1;
    } else {
        if (old.ticks % 4) == 1 {
            new.st = Phase::Recover;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.orders = old.orders + 1;
        }
    }
}

fn waits_nack(old: &State, new: &mut State) {
    if old.svc[Service::Mail as usize] == ServiceState::Up {
        new.st = Phase::Recover;
        new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        new.timer = 8;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Mail as usize] = (old.calls[Service::Mail as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn waits_tmo(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Recover;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 4;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn waits_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_waits(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            waits_tick(old, new);
        }
        Event::Req => {
            waits_req(old, new);
        }
        Event::Ack => {
            waits_ack(old, new);
        }
        Event::Nack => {
            waits_nack(old, new);
        }
        Event::Tmo => {
            waits_tmo(old, new);
        }
        _ => {
            waits_other(old, new);
        }
    }
}

fn recover_tick(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Failed;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 3;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn recover_req(old: &State, new: &mut State) {
    if old.svc[Service::Bank as usize] == ServiceState::Up {
        new.st = Phase::Failed;
        new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
        new.timer = 4;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Bank as usize] = (old.calls[Service::Bank as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn recover_ack(old: &State, new: &mut State) {
    if (old.timer > 0) && (old.svc[Service::Stock as usize] != ServiceState::Down) {
        new.timer = old.timer - 1;
        new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
    } else {
        new.st = Phase::Ship;
        new.timer = 4;
        new.hist[Phase::Recover as usize] = old.hist[Phase::Recover as usize] + 1;
    }
}

fn recover_nack(old: &State, new: &mut State) {
    if ((old.orders % 5) == 0) || (old.retries > 1) {
        new.st = Phase::Failed;
        new.retries = 0;
        new.hist[Phase::Recover as usize] = old.hist[Phase::Recover as usize] + 1;
    } else {
        if old.timer >= 3 {
            new.timer = old.timer - 3;
            new.retries = old.retries + 1;
        } else {
            new.st = Phase::Failed;
        }
    }
}

fn recover_tmo(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Up {
        new.st = Phase::Failed;
        new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        new.timer = 6;
    } else {
        if old.retries < 3 {
            new.retries = old.retries + 1;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.st = Phase::Recover;
            new.retries = 0;
            new.errors = old.errors + 1;
        }
    }
}

fn recover_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_recover(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            recover_tick(old, new);
        }
        Event::Req => {
            recover_req(old, new);
        }
        Event::Ack => {
            recover_ack(old, new);
        }
        Event::Nack => {
            recover_nack(old, new);
        }
        Event::Tmo => {
            recover_tmo(old, new);
        }
        _ => {
            recover_other(old, new);
        }
    }
}

fn failed_tick(old: &State, new: &mut State) {
    match old.svc[Service::Stock as usize] {
        ServiceState::Up => {
            new.st = Phase::Boot;
            new.orders = old.orders + 1;
        }
        ServiceState::Slow => {
            new.st = Phase::Waits;
            new.timer = 5;
        }
        _ => {
            new.st = Phase::Recover;
        }
    }
}

fn failed_ack(old: &State, new: &mut State) {
    if old.svc[Service::Stock as usize] == ServiceState::Down {
        new.st = Phase::Recover;
        new.errors = old.errors + 1;
    } else {
        if (old.ticks % 4) == 1 {
            new.st = Phase::Boot;
            new.calls[Service::Stock as usize] = (old.calls[Service::Stock as usize] + 1) % 1000;
        } else {
            new.orders = old.orders + 1;
        }
    }
}

fn failed_nack(old: &State, new: &mut State) {
    if old.svc[Service::Auth as usize] == ServiceState::Down {
        new.st = Phase::Recover;
        new.errors = old.errors + 1;
    } else {
        if (old.ticks % 4) == 1 {
            new.st = Phase::Boot;
            new.calls[Service::Auth as usize] = (old.calls[Service::Auth as usize] + 1) % 1000;
        } else {
            new.orders = old.orders + 1;
        }
    }
}

fn failed_tmo(old: &State, new: &mut State) {
    match old.svc[Service::Stock as usize] {
        ServiceState::Up => {
            new.st = Phase::Boot;
            new.orders = old.orders + 1;
        }
        ServiceState::Slow => {
            new.st = Phase::Waits;
            new.timer = 5;
        }
        _ => {
            new.st = Phase::Recover;
        }
    }
}

fn failed_other(old: &State, new: &mut State) {
    if old.ev == Event::Rst {
        new.st = Phase::Boot;
        new.retries = 0;
    }
}

fn in_failed(old: &State, new: &mut State) {
    match old.ev {
        Event::Tick => {
            failed_tick(old, new);
        }
        Event::Ack => {
            failed_ack(old, new);
        }
        Event::Nack => {
            failed_nack(old, new);
        }
        Event::Tmo => {
            failed_tmo(old, new);
        }
        Event::Req | Event::Rst => {
            failed_other(old, new);
        }
    }
}

fn step(old: &State, new: &mut State) {
    event(old, new);
    timer(old, new);
    for which in SERVICES {
        service(old, new, which);
    }
    match old.st {
        Phase::Boot => {
            in_boot(old, new);
        }
        Phase::Ready => {
            in_ready(old, new);
        }
        Phase::Order => {
            in_order(old, new);
        }
        Phase::Pay => {
            in_pay(old, new);
        }
        Phase::Ship => {
            in_ship(old, new);
        }
        Phase::Waits => {
            in_waits(old, new);
        }
        Phase::Recover => {
            in_recover(old, new);
        }
        Phase::Failed => {
            in_failed(old, new);
        }
    }
}
