//! Changes of the session that take more than one value: shared by buttons and keys.

use agenticfocus::{
    clip::FrameIndex,
    session::{Command, Document, LayerOrder, LayerOrderRange, SidesSwapped},
};

/// What is to change about the layer order of some frames; the rest stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerOrderChange {
    /// The order.
    Order(LayerOrder),
    /// The thumb pass; `None` leaves it to the contact.
    Thumb(Option<bool>),
}

/// The layer order that holds on `frame`: later ranges win.
pub fn layer_order_on(document: &Document, frame: FrameIndex) -> (LayerOrder, Option<bool>) {
    let holds = |range: &&LayerOrderRange| range.first <= frame && frame <= range.last;
    document
        .layer_orders
        .iter()
        .rev()
        .find(holds)
        .map_or((LayerOrder::Auto, None), |range| (range.order, range.thumb))
}

/// Sets order or thumb pass on the frames `first` to `last`, both included. Ranges below are cut, not covered, so
/// that the list stays as short as what it says.
pub fn with_layer_order(
    document: &Document,
    first: FrameIndex,
    last: FrameIndex,
    change: LayerOrderChange,
) -> Command {
    let (order, thumb) = layer_order_on(document, first);
    let (order, thumb) = match change {
        LayerOrderChange::Order(order) => (order, thumb),
        LayerOrderChange::Thumb(thumb) => (order, thumb),
    };
    let mut orders = cut(&document.layer_orders, first, last);
    if (order, thumb) != (LayerOrder::Auto, None) {
        orders.push(LayerOrderRange { first, last, order, thumb });
    }
    orders.sort_by_key(|range| range.first);
    Command::SetLayerOrders(orders)
}

/// Leaves the frames of range `index` to the machine again.
pub fn without_layer_order(document: &Document, index: usize) -> Command {
    let mut orders = document.layer_orders.clone();
    if index < orders.len() {
        orders.remove(index);
    }
    Command::SetLayerOrders(orders)
}

/// `orders` without the frames `first` to `last`.
fn cut(orders: &[LayerOrderRange], first: FrameIndex, last: FrameIndex) -> Vec<LayerOrderRange> {
    let mut rest = Vec::new();
    for range in orders {
        if range.first < first {
            let last = FrameIndex(range.last.0.min(first.0 - 1));
            rest.push(LayerOrderRange { last, ..*range });
        }
        if range.last > last {
            let first = FrameIndex(range.first.0.max(last.0 + 1));
            rest.push(LayerOrderRange { first, ..*range });
        }
    }
    rest
}

/// Takes the exchange of left and right number `index` back.
pub fn without_swap(document: &Document, index: usize) -> Command {
    let mut ranges: Vec<SidesSwapped> = document.sides_swapped.clone();
    if index < ranges.len() {
        ranges.remove(index);
    }
    Command::SetSidesSwapped(ranges)
}

/// Cuts the template from `frame`, or from where the machine likes best. A mask drawn on another frame goes with it.
pub fn choose_template_frame(document: &Document, frame: Option<FrameIndex>) -> Command {
    let choose = Command::SetTemplateFrame(frame);
    if document.template.mask.is_none() || document.template.frame == frame {
        return choose;
    }
    Command::Together(vec![choose, Command::SetTemplateMask(None)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(first: u32, last: u32, order: LayerOrder) -> LayerOrderRange {
        LayerOrderRange { first: FrameIndex(first), last: FrameIndex(last), order, thumb: None }
    }

    fn orders_of(command: Command) -> Vec<LayerOrderRange> {
        match command {
            Command::SetLayerOrders(orders) => orders,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_order_in_the_middle_of_another_cuts_it_in_two() {
        use LayerOrder::{ObjectInFront, RobotInFront};
        let document = Document { layer_orders: vec![range(0, 20, RobotInFront)], ..Document::default() };
        let change = LayerOrderChange::Order(ObjectInFront);
        let orders = orders_of(with_layer_order(&document, FrameIndex(5), FrameIndex(9), change));
        let expected = [range(0, 4, RobotInFront), range(5, 9, ObjectInFront), range(10, 20, RobotInFront)];
        assert_eq!(orders, expected);
    }

    #[test]
    fn auto_leaves_no_range_behind_and_the_thumb_keeps_its_order() {
        let document =
            Document { layer_orders: vec![range(3, 6, LayerOrder::ObjectInFront)], ..Document::default() };
        let auto = LayerOrderChange::Order(LayerOrder::Auto);
        assert!(orders_of(with_layer_order(&document, FrameIndex(0), FrameIndex(9), auto)).is_empty());
        let thumb = LayerOrderChange::Thumb(Some(false));
        let orders = orders_of(with_layer_order(&document, FrameIndex(3), FrameIndex(6), thumb));
        assert_eq!(
            orders,
            [LayerOrderRange { thumb: Some(false), ..range(3, 6, LayerOrder::ObjectInFront) }]
        );
    }
}
